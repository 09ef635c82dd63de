//! The path tracer: the ground truth.
//!
//! Unidirectional and unbiased. Surfaces are two-sided and Lambertian with flat normals. At every
//! vertex the punctual lights are sampled (next-event estimation); emissive surfaces and the sky
//! count when a ray meets them. Paths end by Russian roulette or by leaving the scene, never by a
//! depth limit.
//!
//! What counts as what:
//!
//! | light | arrives straight | after one reflection or more |
//! |---|---|---|
//! | punctual lights | direct | indirect |
//! | sky | direct ([`Arriving::sky`]) | indirect |
//! | emissive surfaces | indirect | indirect |

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::{
    Ray, World,
    sampling::{Frame, PathSampler, cosine_hemisphere},
    scene::LightSample,
    visibility::{offset_origin, shadow_ray},
};

/// Up to this many lights are all sampled at every vertex; of more, one is drawn.
pub const SAMPLE_ALL_LIGHTS: usize = 8;

/// Reflections before Russian roulette starts.
const ROULETTE_START: u32 = 3;

/// Highest probability of survival, so that paths end even between perfect reflectors.
const ROULETTE_MAX: f32 = 0.95;

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

/// Follows one path from `origin` into the unit direction `direction`. Punctual lights do not count
/// at the origin. `sampler` must not have given its first direction to anything else than
/// `direction`: the next ones are used here.
#[must_use]
pub fn trace_path(
    world: &World,
    origin: Vec3,
    direction: Vec3,
    sampler: &mut PathSampler,
) -> Arriving {
    trace_path_with(world, origin, direction, sampler, ROULETTE_START)
}

fn trace_path_with(
    world: &World,
    origin: Vec3,
    direction: Vec3,
    sampler: &mut PathSampler,
    roulette_start: u32,
) -> Arriving {
    let mut out = Arriving { distance: f32::INFINITY, ..Arriving::default() };
    // Radiance at the current vertex times this arrives at the origin.
    let mut throughput = Vec3::ONE;
    let mut ray = Ray::new(origin, direction);
    let mut reflections = 0_u32;
    loop {
        let hit = world.closest(&ray);
        if !hit.is_hit() {
            let sky = throughput * world.sky.radiance(ray.direction);
            match reflections {
                0 => out.sky = sky,
                1 => {
                    out.indirect += sky;
                    out.one_bounce += sky;
                }
                _ => out.indirect += sky,
            }
            return out;
        }
        if reflections == 0 {
            out.distance = hit.t;
        }
        let surface = world.surface(&hit, ray.direction);
        let emitted = throughput * surface.emission;
        out.indirect += emitted;
        if reflections <= 1 {
            out.one_bounce += emitted;
        }

        throughput *= surface.albedo;
        if throughput == Vec3::ZERO {
            return out;
        }
        let next = offset_origin(surface.position, surface.normal);
        let lit = sample_lights(world, surface.position, surface.normal, next, sampler);
        let reflected = throughput * lit * FRAC_1_PI;
        out.indirect += reflected;
        if reflections == 0 {
            out.one_bounce += reflected;
        }

        reflections += 1;
        if reflections >= roulette_start {
            let survival = throughput.max_element().min(ROULETTE_MAX);
            if sampler.next_1d() >= survival {
                return out;
            }
            throughput /= survival;
        }
        let local = cosine_hemisphere(sampler.next_2d());
        ray = Ray::new(next, Frame::new(surface.normal).to_world(local));
    }
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

/// Irradiance from the punctual lights: the sum over all for few lights, else an unbiased estimate
/// from one light, drawn with a probability proportional to the (largest channel of the) irradiance
/// it would give without shadows.
fn sample_lights(
    world: &World,
    point: Vec3,
    normal: Vec3,
    origin: Vec3,
    sampler: &mut PathSampler,
) -> Vec3 {
    if world.lights.len() <= SAMPLE_ALL_LIGHTS {
        return direct_irradiance(world, point, normal, origin);
    }
    // Weighted reservoir sampling: one pass, no memory.
    let (mut total, mut chosen) = (0.0_f32, None);
    for light in &world.lights {
        let Some((weight, irradiance)) = unshadowed(light.sample(point), normal) else { continue };
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

/// Largest channel and value of the irradiance of a light on a surface; `None` where it is 0.
fn unshadowed(sample: Option<LightSample>, normal: Vec3) -> Option<(f32, Vec3)> {
    let sample = sample?;
    let irradiance = sample.irradiance * normal.dot(sample.to_light);
    let weight = irradiance.max_element();
    (weight > 0.0).then_some((weight, irradiance))
}
