//! Light that reaches patches straight from punctual lights.

use std::collections::BTreeMap;

use glam::Vec3;
use rayon::prelude::*;

use super::patches::Patches;
use crate::{
    World,
    scene::{Light, LightId},
    visibility::{offset_origin, shadow_ray},
};

/// What one light sends to every patch, for an intensity of one: a light whose intensity changes
/// asks for no ray.
pub(crate) struct LightTerm {
    pub light: Light,
    /// Irradiance for unit intensity, visibility included, the mean over the patch's sample points.
    factor: Vec<f32>,
}

/// The terms of all lights.
#[derive(Default)]
pub(crate) struct Direct {
    terms: BTreeMap<LightId, LightTerm>,
}

impl Direct {
    /// Takes the lights of a scene over; terms that stay valid are kept. Returns whether any changed.
    pub(crate) fn set_lights(&mut self, lights: &BTreeMap<LightId, Light>) -> bool {
        let same = self.terms.len() == lights.len()
            && self.terms.iter().zip(lights).all(|(a, b)| a.0 == b.0 && a.1.light == *b.1);
        self.terms.retain(|id, _| lights.contains_key(id));
        for (id, light) in lights {
            let term = self
                .terms
                .entry(*id)
                .or_insert_with(|| LightTerm { light: *light, factor: Vec::new() });
            if (Light { intensity: term.light.intensity, ..*light }) != term.light {
                term.factor.clear();
            }
            term.light = *light;
        }
        !same
    }

    /// Forgets what depends on geometry.
    pub(crate) fn invalidate(&mut self) {
        for term in self.terms.values_mut() {
            term.factor.clear();
        }
    }

    /// Casts up to `budget` shadow rays for terms that do not cover all patches yet. Returns whether
    /// all do now.
    pub(crate) fn advance(&mut self, world: &World, patches: &Patches, budget: usize) -> bool {
        let mut left = budget / super::raster::SAMPLES;
        for term in self.terms.values_mut() {
            let start = term.factor.len();
            let end = patches.len().min(start + left);
            left -= end - start;
            term.factor.resize(end, 0.0);
            let light = Light { intensity: Vec3::ONE, ..term.light };
            term.factor[start..]
                .par_iter_mut()
                .with_min_len(64)
                .enumerate()
                .for_each(|(i, factor)| *factor = mean_factor(world, patches, start + i, &light));
            if end < patches.len() {
                return false;
            }
        }
        true
    }

    /// Direct irradiance at a patch.
    pub(crate) fn irradiance(&self, patch: usize) -> Vec3 {
        self.terms
            .values()
            .map(|term| term.light.intensity * term.factor.get(patch).copied().unwrap_or(0.0))
            .sum()
    }
}

/// The mean over a patch's sample points of cosine, falloff, cone and visibility.
fn mean_factor(world: &World, patches: &Patches, patch: usize, light: &Light) -> f32 {
    let samples = &patches.samples[patch];
    let mut sum = 0.0;
    for (&point, &normal) in samples.iter().zip(&patches.sample_normals[patch]) {
        let Some(sample) = light.sample(point) else { continue };
        let cos = normal.dot(sample.to_light);
        if cos <= 0.0 {
            continue;
        }
        if !world.occluded(&shadow_ray(offset_origin(point, normal), light)) {
            sum += sample.irradiance.x * cos;
        }
    }
    sum / samples.len() as f32
}
