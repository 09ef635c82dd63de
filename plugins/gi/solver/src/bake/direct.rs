//! What arrives straight from punctual lights, the mean over each texel's area.

use glam::Vec3;
use rayon::prelude::*;

use super::Layout;
use crate::{World, estimate::Progress, scene::Light, visibility::offset_origin};

/// A light with an extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectLight {
    /// The light.
    pub light: Light,
    /// Radius in metres of a point or spot light, or half the angle in radians of a directional one, that
    /// softens its shadows; 0 for sharp ones.
    pub radius: f32,
}

/// Irradiance at every texel straight from the given lights. `None` if `progress` stopped the work.
#[must_use]
pub fn direct(
    world: &World,
    layout: &Layout,
    lights: &[DirectLight],
    progress: Progress<'_>,
) -> Option<Vec<Vec3>> {
    let patches = &layout.patches;
    (0..layout.len())
        .into_par_iter()
        .with_min_len(64)
        .map(|i| {
            progress(1).is_continue().then(|| {
                let samples = patches.samples[i].iter().zip(&patches.sample_normals[i]);
                let count = samples.len() as f32;
                let sum: Vec3 = samples
                    .flat_map(|(point, normal)| lights.iter().map(move |l| (*point, *normal, l)))
                    .map(|(point, normal, DirectLight { light, .. })| {
                        let Some(sample) = light.sample(point) else { return Vec3::ZERO };
                        let cos = sample.to_light.dot(normal);
                        if cos > 0.0 && world.sees_light(offset_origin(point, normal), light) {
                            sample.irradiance * cos
                        } else {
                            Vec3::ZERO
                        }
                    })
                    .sum();
                sum / count
            })
        })
        .collect()
}
