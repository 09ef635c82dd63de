//! An hour before sunset: a low sun, a sky from gold to blue, bands of cloud that it lights.

use super::{
    PIXEL, SUN_DISC_SHARE,
    landscape::{self, Daylight},
    mix,
    noise::octaves,
    ramp, sun_disc,
};
use crate::assets::part::{P, add, dot, normalize, scale};

/// Eight degrees above the horizon, on the right and a little in front of the object.
const SUN: P = [0.86, 0.14, 0.49];
/// Chosen so that a surface that faces the sun gets one and a half times as much from it as from all
/// else.
const SUNLIGHT: P = [1150.0, 640.0, 260.0];

pub(super) fn radiance(d: P) -> P {
    let sun = normalize(SUN);
    let near = dot(d, sun);
    let glow = near.max(0.0);
    let up = d[1].max(0.0);
    let side = 0.5 + 0.5 * near;
    // Low in the sky gold on the sun's side, rose on the other; blue overhead.
    let low = mix([0.46, 0.36, 0.42], [1.25, 0.72, 0.33], side.powf(1.6));
    let middle = mix([0.30, 0.31, 0.44], [0.72, 0.60, 0.50], side.powi(2));
    let high = mix([0.10, 0.16, 0.33], [0.16, 0.22, 0.40], side);
    let mut light = mix(low, middle, ramp(0.0, 0.30, up));
    light = mix(light, high, ramp(0.08, 0.75, up));
    // The earth's shadow rises opposite.
    let shadow = (1.0 - ramp(0.0, 0.09, up)) * (1.0 - side).powi(2);
    light = mix(light, [0.22, 0.23, 0.33], 0.6 * shadow);
    light = add(light, scale([1.0, 0.62, 0.28], 0.9 * glow.powi(10) + 3.0 * glow.powi(160)));
    if up > 0.01 {
        let (cloud, cover) = bands(d, side, glow);
        light = mix(light, cloud, cover);
    }
    light = add(light, scale(SUNLIGHT, sun_disc(near)));
    let daylight = Daylight {
        sun,
        sunlight: scale(SUNLIGHT, SUN_DISC_SHARE),
        skylight: [0.24, 0.25, 0.31],
        haze: mix([0.34, 0.30, 0.36], [0.95, 0.58, 0.30], side.powi(2)),
    };
    landscape::before(light, d, &daylight)
}

/// Radiance and cover of high clouds in bands across the way to the sun.
fn bands(d: P, side: f64, glow: f64) -> (P, f64) {
    let bend = d[1] + 0.12;
    // Along and across the bands.
    let (x, z) = (d[0] / bend, d[2] / bend);
    let (along, across) = (0.87 * z - 0.49 * x, 0.87 * x + 0.49 * z);
    let footprint = PIXEL / (bend * bend);
    let bent = 0.5 * octaves([along * 0.3 + 4.0, across * 0.3], footprint);
    let density = |shift: f64| {
        let across = across + shift + bent;
        octaves([along * 0.45 + 1.7, across * 1.5], 1.5 * footprint)
            + 0.25 * octaves([along * 2.2, across * 3.1 + 6.0], 3.1 * footprint)
    };
    let here = density(0.0);
    let cover = ramp(-0.02, 0.5, here) * ramp(0.01, 0.10, d[1]);
    // Lit from beneath and from the sun's side.
    let lit = ramp(-0.35, 0.45, here - density(0.12));
    let shade = mix([0.26, 0.23, 0.30], [0.50, 0.36, 0.33], side);
    let fire = mix([0.80, 0.46, 0.44], [1.75, 0.98, 0.46], side.powi(2));
    let bright = add(fire, scale([2.0, 1.1, 0.45], glow.powi(12)));
    (mix(shade, bright, lit), 0.85 * cover)
}
