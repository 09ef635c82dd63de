//! Light at a vertex, straight from where it is made (next-event estimation).

use glam::Vec3;

use super::PathTracer;
use crate::{Ray, World, sampling::PathSampler, scene::LightSample, visibility::shadow_ray};

/// Up to this many punctual lights are all sampled at every vertex; of more, one is drawn.
pub const SAMPLE_ALL_LIGHTS: usize = 8;

/// Ends rays to a point of an emitter just before it.
pub(crate) const EMITTER_END: f32 = 1.0 - 1e-4;

/// Light from one direction, divided by the density with which the direction is drawn by all
/// techniques together (the balance heuristic, Veach and Guibas 1995). Visible.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Toward {
    /// Unit vector towards the light.
    pub(crate) direction: Vec3,
    /// Radiance / (density of this technique + density of the gather ray).
    pub(crate) weighted: Vec3,
}

/// Irradiance from all punctual lights on the side of `normal`, exact. `origin` is the point moved
/// off its surface.
#[must_use]
pub fn direct_irradiance(world: &World, point: Vec3, normal: Vec3, origin: Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for light in &world.lights {
        if let Some((_, irradiance)) = unshadowed(light.sample(point), normal)
            && world.sees_light(origin, light)
        {
            sum += irradiance;
        }
    }
    sum
}

impl PathTracer<'_> {
    /// Irradiance from the punctual lights: the sum over all for few lights, else an unbiased
    /// estimate from one light, drawn with a probability proportional to the (largest channel of
    /// the) irradiance that it would give without shadows.
    pub(crate) fn punctual(
        &self,
        point: Vec3,
        normal: Vec3,
        origin: Vec3,
        sampler: &mut PathSampler,
    ) -> Vec3 {
        let world = self.world;
        if world.lights.len() <= SAMPLE_ALL_LIGHTS {
            return direct_irradiance(world, point, normal, origin);
        }
        // Weighted reservoir sampling: one pass, no memory.
        let (mut total, mut chosen) = (0.0_f32, None);
        for light in &world.lights {
            let Some((weight, irradiance)) = unshadowed(light.sample(point), normal) else {
                continue;
            };
            total += weight;
            if sampler.next_1d() * total < weight {
                chosen = Some((light, irradiance / weight));
            }
        }
        match chosen {
            Some((light, per_weight)) if !world.occluded(&shadow_ray(origin, light)) => {
                per_weight * total
            }
            _ => Vec3::ZERO,
        }
    }

    /// Light from a drawn point of an emitter. `gather_pdf` gives the density per solid angle with
    /// which a ray of the path goes into a direction; what has none is left out.
    pub(crate) fn toward_emitter(
        &self,
        origin: Vec3,
        sampler: &mut PathSampler,
        gather_pdf: impl Fn(Vec3) -> f32,
    ) -> Option<Toward> {
        if self.emitters.is_empty() {
            return None;
        }
        let s = self.emitters.sample(self.world, origin, sampler)?;
        let other = gather_pdf(s.direction);
        if other <= 0.0 {
            return None;
        }
        let ray = Ray { t_max: EMITTER_END, ..Ray::new(origin, s.offset) };
        (!self.world.occluded(&ray))
            .then(|| Toward { direction: s.direction, weighted: s.radiance / (s.pdf + other) })
    }

    /// Light from a drawn direction of a sky image, as [`toward_emitter`](Self::toward_emitter).
    pub(crate) fn toward_sky(
        &self,
        origin: Vec3,
        sampler: &mut PathSampler,
        gather_pdf: impl Fn(Vec3) -> f32,
    ) -> Option<Toward> {
        let s = self.sky.as_ref()?.sample(sampler);
        let other = gather_pdf(s.direction);
        if other <= 0.0 || s.pdf <= 0.0 || self.world.occluded(&Ray::new(origin, s.direction)) {
            return None;
        }
        let radiance = self.world.sky.radiance(s.direction);
        Some(Toward { direction: s.direction, weighted: radiance / (s.pdf + other) })
    }
}

/// Largest channel and value of the irradiance of a light on a surface; `None` where it is 0.
fn unshadowed(sample: Option<LightSample>, normal: Vec3) -> Option<(f32, Vec3)> {
    let sample = sample?;
    let irradiance = sample.irradiance * normal.dot(sample.to_light);
    let weight = irradiance.max_element();
    (weight > 0.0).then_some((weight, irradiance))
}
