//! What lies beneath a sky: hills far away, a line of trees, a meadow with a path.

use super::{PIXEL, mix, noise::octaves, ramp};
use crate::assets::part::{P, add, dot, scale};

/// Of the eye above the meadow, in metres.
const EYE: f64 = 1.6;

/// The light that falls on a landscape; each value is irradiance over pi.
pub(super) struct Daylight {
    /// Towards the sun, of length 1.
    pub(super) sun: P,
    /// The sun's on a surface that faces it.
    pub(super) sunlight: P,
    /// The sky's on level ground.
    pub(super) skylight: P,
    /// Radiance of the air in front of distant things.
    pub(super) haze: P,
}

impl Daylight {
    fn on(&self, normal: P, sky: f64) -> P {
        let facing = dot(normal, self.sun).max(0.0);
        add(scale(self.sunlight, facing), scale(self.skylight, sky))
    }
}

/// The landscape in front of the radiance of the sky behind it.
pub(super) fn before(sky: P, d: P, light: &Daylight) -> P {
    let flat = (d[0] * d[0] + d[2] * d[2]).sqrt().max(1e-6);
    let level = [d[0] / flat, 0.0, d[2] / flat];
    let covered = |height: f64, soft: f64| 1.0 - ramp(height - soft, height + soft, d[1]);
    let mut seen = sky;
    // Slopes and trees on the side that the sun is on show their shadowed side.
    let facing = [-level[0] * 0.8, 0.6, -level[2] * 0.8];
    let hills = 0.045 + 0.07 * octaves([level[0] * 1.6 + 4.0, level[2] * 1.6], PIXEL);
    let lit = tint([0.10, 0.14, 0.08], light.on(facing, 0.8));
    seen = mix(seen, mix(lit, light.haze, 0.55), covered(hills, PIXEL * 0.4));
    let crowns = octaves([level[0] * 9.0, level[2] * 9.0 + 2.0], PIXEL * 4.0);
    let trees =
        0.022 + 0.04 * octaves([level[0] * 2.2, level[2] * 2.2 + 7.0], PIXEL) + 0.012 * crowns;
    let lit = tint([0.055, 0.085, 0.035], light.on(facing, 0.55 + 0.4 * crowns));
    seen = mix(seen, mix(lit, light.haze, 0.10), covered(trees, PIXEL * 0.5));
    if d[1] < PIXEL {
        let ground = meadow([d[0], d[1].min(-0.3 * PIXEL), d[2]], light);
        seen = mix(seen, ground, covered(0.0, PIXEL * 0.5));
    }
    seen
}

fn meadow(d: P, light: &Daylight) -> P {
    let [x, z] = [d[0], d[2]].map(|v| v * EYE / -d[1]);
    // A pixel covers more along the view than across it.
    let footprint = PIXEL * EYE / (d[1] * d[1]).max(1e-4);
    let patches = octaves([x / 9.0, z / 9.0], footprint / 9.0);
    let tufts = octaves([x / 0.7 + 31.0, z / 0.7], footprint / 0.7);
    let grass = mix([0.07, 0.12, 0.03], [0.19, 0.19, 0.07], ramp(-0.6, 0.6, patches + 0.3 * tufts));
    let grass = scale(grass, 1.0 + 0.55 * tufts);
    let pebbles = octaves([x / 0.25, z / 0.25 + 5.0], footprint / 0.25);
    let path = scale([0.32, 0.26, 0.19], 1.0 + 0.4 * pebbles);
    // It winds past the eye on the left and fades into the grass.
    let middle = -1.9 + 1.3 * (z / 7.0).sin() + 0.3 * octaves([z / 3.0, 0.5], footprint / 3.0);
    let edge = 0.25 + 0.5 * footprint;
    let trodden = 1.0 - ramp(0.55 - edge, 0.55 + edge, (x - middle).abs());
    let albedo = mix(grass, path, 0.9 * trodden * (0.6 / footprint).min(1.0));
    let lit = tint(albedo, light.on([0.0, 1.0, 0.0], 1.0));
    let distance = EYE / -d[1];
    mix(light.haze, lit, (-distance / 900.0).exp())
}

fn tint(albedo: P, light: P) -> P {
    [0, 1, 2].map(|k| albedo[k] * light[k])
}
