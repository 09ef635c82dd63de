//! A clear day: sun, blue sky, some clouds, meadows to the horizon.

use super::{mix, ramp};
use crate::assets::part::{P, add, dot, normalize, scale};

const SUN: P = [0.62, 0.62, 0.55];
/// Cosines of the angles where the sun's disc ends and where its edge begins. It is larger than the
/// real one, so that some pixels hold it.
const DISC: [f64; 2] = [0.9994, 0.9998];
/// Chosen so that the sun gives about four times what the sky gives.
const SUNLIGHT: P = [2500.0, 2250.0, 1850.0];

pub(super) fn radiance(d: P) -> P {
    let sun = normalize(SUN);
    let near = dot(d, sun);
    let up = d[1];
    // The sky pales towards the horizon and the sun.
    let mut light = mix([0.80, 0.90, 1.02], [0.12, 0.27, 0.66], ramp(-0.15, 0.85, up).powf(0.8));
    let glow = near.max(0.0);
    light = add(light, scale([1.0, 0.9, 0.7], 0.35 * glow.powi(8) + 1.6 * glow.powi(120)));
    if up > 0.02 {
        // Clouds on a ceiling, smaller and fainter with distance.
        let (x, z) = (d[0] / (up + 0.12), d[2] / (up + 0.12));
        let density = ramp(0.52, 0.86, clouds(x * 1.1 + 3.7, z * 1.1 + 1.3)) * ramp(0.02, 0.25, up);
        let lit = add([0.92, 0.94, 0.98], scale([0.9, 0.8, 0.65], glow.powi(6)));
        light = mix(light, lit, 0.85 * density);
    }
    light = add(light, scale(SUNLIGHT, ramp(DISC[0], DISC[1], near)));
    // Hills, then meadows that the sun lights.
    let hills = 0.018 + 0.02 * clouds(d[0] * 3.0 + 9.0, d[2] * 3.0);
    let ground = mix([0.21, 0.27, 0.11], [0.32, 0.37, 0.30], ramp(-0.25, 0.0, up));
    mix(ground, light, ramp(hills - 0.004, hills + 0.004, up))
}

/// Three octaves of value noise, 0..1.
fn clouds(x: f64, y: f64) -> f64 {
    0.55 * noise(x, y) + 0.30 * noise(2.1 * x + 5.2, 2.1 * y) + 0.15 * noise(4.3 * x, 4.3 * y + 8.1)
}

fn noise(x: f64, y: f64) -> f64 {
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let at = |dx: i64, dy: i64| {
        let (x, y) = (x.floor() as i64 + dx, y.floor() as i64 + dy);
        let mut h = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        h = (h ^ h >> 31).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        h = (h ^ h >> 29).wrapping_mul(0x94d0_49bb_1331_11eb);
        (h >> 40) as f64 / (1_u64 << 24) as f64
    };
    let (tx, ty) = (ramp(0.0, 1.0, fx), ramp(0.0, 1.0, fy));
    let row = |dy: i64| at(0, dy) + (at(1, dy) - at(0, dy)) * tx;
    row(0) + (row(1) - row(0)) * ty
}
