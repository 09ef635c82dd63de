//! The path tracer: the ground truth.
//!
//! Unidirectional and unbiased. Surfaces are two-sided and Lambertian with flat normals. At every
//! vertex the punctual lights are sampled, and so are, where there are any, a point of the emissive
//! surfaces and a direction of the sky image; what a ray meets by chance is weighed against that
//! (multiple importance sampling). Paths end by Russian roulette or by leaving the scene, never by a
//! depth limit.
//!
//! What counts as what:
//!
//! | light | arrives straight | after one reflection or more |
//! |---|---|---|
//! | punctual lights | direct | indirect |
//! | sky | direct ([`Arriving::sky`]) | indirect |
//! | emissive surfaces | indirect | indirect |

mod emitters;
mod lights;
mod roulette;
mod sky;
mod table;

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::{
    Hit, Ray, World,
    sampling::{Frame, PathSampler, cosine_hemisphere},
    visibility::offset_origin,
    world::Surface,
};
use emitters::Emitters;
use roulette::Roulette;
use sky::SkyTexels;

pub(crate) use lights::{EMITTER_END, Toward};
pub use lights::{SAMPLE_ALL_LIGHTS, direct_irradiance};
pub(crate) use table::Table;

/// Radiance that arrives at a point along one ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arriving {
    /// Straight from the sky.
    pub sky: Vec3,
    /// From surfaces: emitted, or reflected any number of times. An unbiased estimate.
    pub indirect: Vec3,
    /// The part of `indirect` that was reflected once at most.
    pub one_bounce: Vec3,
    /// Distance to the surface that was met, infinite for the sky.
    pub distance: f32,
}

/// Follows paths through a world.
pub struct PathTracer<'w> {
    world: &'w World,
    emitters: Emitters,
    sky: Option<SkyTexels<'w>>,
    roulette: Roulette,
}

impl<'w> PathTracer<'w> {
    /// Prepares paths through a world: makes tables of what emits, in time proportional to the
    /// emissive triangles and the texels of the sky image.
    #[must_use]
    pub fn new(world: &'w World) -> Self {
        Self {
            world,
            emitters: Emitters::new(world),
            sky: SkyTexels::new(&world.sky),
            roulette: Roulette::STANDARD,
        }
    }

    /// The world that paths go through.
    #[must_use]
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// Follows one path from `origin` into the unit direction `direction`. Punctual lights do not
    /// count at the origin. `sampler` gives the numbers from the path's second direction on: draw
    /// `direction` with its first.
    #[must_use]
    pub fn trace(&self, origin: Vec3, direction: Vec3, sampler: &mut PathSampler) -> Arriving {
        self.trace_weighed(origin, direction, None, sampler)
    }

    /// As [`trace`](Self::trace), for a caller that also samples emitters and the sky at the origin:
    /// `pdf` is the density per solid angle with which it draws `direction`, and what arrives
    /// straight is weighed accordingly.
    pub(crate) fn trace_weighed(
        &self,
        origin: Vec3,
        direction: Vec3,
        mut pdf: Option<f32>,
        sampler: &mut PathSampler,
    ) -> Arriving {
        let world = self.world;
        let mut out = Arriving { distance: f32::INFINITY, ..Arriving::default() };
        // Radiance at the current vertex times this arrives at the origin.
        let mut throughput = Vec3::ONE;
        let mut ray = Ray::new(origin, direction);
        let mut reflections = 0_u32;
        loop {
            let hit = world.closest(&ray);
            if !hit.is_hit() {
                let sky = throughput * self.sky_met(ray.direction, pdf);
                match reflections {
                    0 => out.sky = sky,
                    _ => out.add(sky, reflections),
                }
                return out;
            }
            if reflections == 0 {
                out.distance = hit.t;
            }
            let surface = world.surface(&hit, ray.direction);
            if surface.emission != Vec3::ZERO {
                out.add(throughput * self.emission_met(&surface, &ray, &hit, pdf), reflections);
            }

            throughput *= surface.albedo;
            if throughput == Vec3::ZERO {
                return out;
            }
            reflections += 1;
            let next = offset_origin(surface.position, surface.normal);
            let cosine_pdf = |d: Vec3| surface.normal.dot(d).max(0.0) * FRAC_1_PI;
            let lit = self.punctual(surface.position, surface.normal, next, sampler);
            out.add(throughput * lit * FRAC_1_PI, reflections);
            // The reflectance times the cosine is the albedo times the density of the gather ray.
            for toward in [
                self.toward_emitter(next, sampler, cosine_pdf),
                self.toward_sky(next, sampler, cosine_pdf),
            ]
            .into_iter()
            .flatten()
            {
                out.add(throughput * toward.weighted * cosine_pdf(toward.direction), reflections);
            }

            if !self.goes_on(&mut throughput, reflections, sampler) {
                return out;
            }
            let local = cosine_hemisphere(sampler.next_2d());
            pdf = Some(local.z * FRAC_1_PI);
            ray = Ray::new(next, Frame::new(surface.normal).to_world(local));
        }
    }
}

impl PathTracer<'_> {
    /// Radiance of the sky that a ray met which was drawn with density `pdf`, weighed against
    /// [`toward_sky`](Self::toward_sky).
    pub(crate) fn sky_met(&self, direction: Vec3, pdf: Option<f32>) -> Vec3 {
        let other = self.sky.as_ref().map_or(0.0, |sky| sky.pdf(direction));
        self.world.sky.radiance(direction) * balance(pdf, other)
    }

    /// Radiance that a surface emits which a ray met, weighed against
    /// [`toward_emitter`](Self::toward_emitter).
    pub(crate) fn emission_met(
        &self,
        surface: &Surface,
        ray: &Ray,
        hit: &Hit,
        pdf: Option<f32>,
    ) -> Vec3 {
        let cos = surface.normal.dot(ray.direction);
        surface.emission * balance(pdf, self.emitters.pdf_of_hit(hit, cos))
    }

    /// Whether a path whose throughput this is goes on; if so, its weight changes.
    pub(crate) fn goes_on(
        &self,
        throughput: &mut Vec3,
        reflections: u32,
        sampler: &mut PathSampler,
    ) -> bool {
        let survival = self.roulette.survival(*throughput, reflections);
        if survival < 1.0 {
            if sampler.next_1d() >= survival {
                return false;
            }
            *throughput /= survival;
        }
        true
    }
}

impl Arriving {
    fn add(&mut self, light: Vec3, reflections: u32) {
        self.indirect += light;
        if reflections <= 1 {
            self.one_bounce += light;
        }
    }
}

/// Weight of what a ray met by chance, drawn with density `pdf`, if another technique draws it with
/// density `other`; 1 if there is no other.
pub(crate) fn balance(pdf: Option<f32>, other: f32) -> f32 {
    match pdf {
        Some(pdf) if other > 0.0 => pdf / (pdf + other),
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests;
