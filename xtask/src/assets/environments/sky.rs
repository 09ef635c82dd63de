//! A clear day: sun, blue sky, fair-weather clouds, a meadow to the hills.

use super::{
    PIXEL, SUN_DISC_SHARE,
    landscape::{self, Daylight},
    mix,
    noise::octaves,
    ramp, sun_disc,
};
use crate::assets::part::{P, add, dot, normalize, scale};

const SUN: P = [0.62, 0.62, 0.55];
/// Chosen so that a surface that faces the sun gets three and a half times as much from it as from
/// all else.
const SUNLIGHT: P = [2500.0, 2250.0, 1850.0];

pub(super) fn radiance(d: P) -> P {
    let sun = normalize(SUN);
    let near = dot(d, sun);
    let glow = near.max(0.0);
    let up = d[1].max(0.0);
    // The sky pales towards the horizon and the sun.
    let mut light = mix([0.78, 0.88, 1.0], [0.11, 0.25, 0.62], ramp(-0.15, 0.85, up).powf(0.8));
    light = add(light, scale([1.0, 0.9, 0.7], 0.30 * glow.powi(8) + 1.6 * glow.powi(120)));
    let (cloud, cover) = clouds(d, sun, glow);
    light = mix(light, cloud, cover);
    // The sun stands clear of the clouds.
    light = add(light, scale(SUNLIGHT, sun_disc(near)));
    let daylight = Daylight {
        sun,
        sunlight: scale(SUNLIGHT, SUN_DISC_SHARE),
        skylight: [0.36, 0.46, 0.64],
        haze: [0.62, 0.72, 0.84],
    };
    landscape::before(light, d, &daylight)
}

/// Radiance and cover of heaps of cloud on a ceiling, smaller and fainter with distance.
fn clouds(d: P, sun: P, glow: f64) -> (P, f64) {
    let up = d[1];
    if up < 0.01 {
        return ([0.0; 3], 0.0);
    }
    let bend = up + 0.10;
    let at = [1.25 * d[0] / bend + 3.7, 1.25 * d[2] / bend + 1.3];
    let footprint = 1.25 * PIXEL / (bend * bend);
    let density = |[x, y]: [f64; 2]| {
        // Bent by another noise, the heaps curl.
        let bent = 0.35 * octaves([x * 0.7 + 11.0, y * 0.7], footprint);
        octaves([x + bent, y - bent], footprint)
    };
    let here = density(at);
    let cover = ramp(0.10, 0.34, here) * ramp(0.01, 0.12, up);
    // How much cloud stands between this place and the sun.
    let towards = [at[0] + 0.22 * sun[0], at[1] + 0.22 * sun[2]];
    let lit = ramp(-0.28, 0.30, here - density(towards).max(-0.1));
    let thick = ramp(0.15, 0.8, here);
    let shade = mix([0.60, 0.66, 0.76], [0.36, 0.40, 0.48], thick);
    let bright = add([1.02, 0.99, 0.94], scale([1.0, 0.85, 0.65], glow.powi(8)));
    (mix(shade, bright, lit), 0.95 * cover)
}
