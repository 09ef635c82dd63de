//! A photographer's studio: a grey room, soft boxes, a paper background.

use super::{mix, ramp};
use crate::assets::part::{P, add, cross, dot, normalize, scale};

/// A rectangle of light: towards its middle, half its width and height (as a tangent of the angle
/// seen from the object), its radiance.
struct Box {
    towards: P,
    half: [f64; 2],
    radiance: P,
}

const BOXES: [Box; 4] = [
    // Key light: high on the right, in front.
    Box { towards: [0.75, 0.62, 0.72], half: [0.42, 0.42], radiance: [13.0, 12.4, 11.4] },
    // Fill: large and weak, on the left.
    Box { towards: [-1.0, 0.25, 0.45], half: [0.75, 0.6], radiance: [1.5, 1.65, 1.85] },
    // A strip behind, for the rim.
    Box { towards: [-1.0, 0.4, -0.42], half: [0.09, 0.5], radiance: [10.0, 10.5, 11.5] },
    // Overhead.
    Box { towards: [0.1, 1.0, -0.35], half: [0.4, 0.3], radiance: [3.4, 3.3, 3.2] },
];

pub(super) fn radiance(d: P) -> P {
    // Walls that grow darker upwards, a floor of paper that runs up behind the object.
    let wall = mix([0.17, 0.17, 0.18], [0.055, 0.056, 0.062], ramp(-0.1, 0.8, d[1]));
    let mut light = mix([0.30, 0.29, 0.28], wall, ramp(-0.35, 0.12, d[1]));
    // The pool of light on the floor, under the key light.
    let pool = (dot(d, normalize([0.2, -0.9, 0.2]))).max(0.0);
    light = add(light, scale([0.24, 0.23, 0.21], pool * pool));
    for Box { towards, half, radiance } in &BOXES {
        let middle = normalize(*towards);
        let right = normalize(cross([0.0, 1.0, 0.0], middle));
        let up = cross(middle, right);
        let facing = dot(d, middle);
        if facing <= 0.0 {
            continue;
        }
        let (x, y) = (dot(d, right) / facing, dot(d, up) / facing);
        let inside = |v: f64, half: f64| 1.0 - ramp(half * 0.93, half * 1.03, v.abs());
        // Brighter in the middle, where the flash is.
        let hot = 1.12 - 0.35 * (x * x / (half[0] * half[0]) + y * y / (half[1] * half[1]));
        light = mix(light, scale(*radiance, hot.max(0.5)), inside(x, half[0]) * inside(y, half[1]));
    }
    light
}
