//! Each light by itself.

use super::{EnvironmentLight, density::Density};
use crate::random::Random;

/// N lights, each radiance / (N pdf).
pub(super) fn lights(density: &Density, count: usize, seed: u64) -> Vec<EnvironmentLight> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|_| {
            let point = density.sample([random.unit(), random.unit()]);
            let irradiance = density.weight(point.texel) / count as f64;
            EnvironmentLight {
                direction: point.direction.as_vec3(),
                irradiance: irradiance.as_vec3(),
            }
        })
        .collect()
}
