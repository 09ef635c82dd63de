//! Each light by itself.

use super::{EnvironmentLight, density::Density};
use crate::random::Random;

/// N lights, each radiance / (N pdf).
pub(super) fn lights(
    density: &Density,
    count: usize,
    random: &mut Random,
) -> Vec<EnvironmentLight> {
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
