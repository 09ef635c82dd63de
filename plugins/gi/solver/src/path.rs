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

/// When paths are ended at random.
///
/// A path survives with probability min(1, throughput / `threshold`), throughput being its largest
/// channel, and from `forced_after` reflections on with 0.95 at most, so that it ends even between
/// perfect reflectors. Survivors are weighted up by the inverse, which keeps the mean.
#[derive(Clone, Copy, Debug)]
struct Roulette {
    threshold: f32,
    forced_after: u32,
}

impl Roulette {
    /// Ends what carries less than a tenth. Earlier ends make paths cheaper and noisier: in two
    /// rooms joined by a doorway a threshold of 1 has 2.5 times the variance at 0.45 times the time,
    /// one of 0.01 the same variance at 1.6 times the time.
    const STANDARD: Self = Self { threshold: 0.1, forced_after: 24 };

    fn survival(self, throughput: Vec3, reflections: u32) -> f32 {
        let most = if reflections > self.forced_after { 0.95 } else { 1.0 };
        (throughput.max_element() / self.threshold).min(most)
    }
}

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
    trace_path_with(world, origin, direction, sampler, Roulette::STANDARD)
}

fn trace_path_with(
    world: &World,
    origin: Vec3,
    direction: Vec3,
    sampler: &mut PathSampler,
    roulette: Roulette,
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
        let survival = roulette.survival(throughput, reflections);
        if survival < 1.0 {
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine3A, Vec4};

    use super::*;
    use crate::{
        Scene,
        sampling::{Rng, uniform_sphere},
        scene::{
            Instance, InstanceId, Light, LightId, LightKind, Material, MaterialId, Mesh, MeshId,
        },
    };

    /// A tetrahedron of four diffuse colours around a light.
    fn tetrahedron() -> World {
        let mut scene = Scene::default();
        let corners = [
            Vec3::ZERO,
            Vec3::new(3.0, 0.0, 0.0),
            Vec3::new(0.0, 3.0, 0.0),
            Vec3::new(0.0, 0.0, 3.0),
        ];
        let faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
        for (i, face) in faces.into_iter().enumerate() {
            let id = i as u64;
            let mesh =
                Mesh { positions: corners.to_vec(), triangles: vec![face], ..Mesh::default() };
            let albedo = 0.3 + 0.2 * i as f32;
            let material = Material {
                base_color: Vec4::new(albedo, 1.0 - albedo, 0.8, 1.0),
                ..Material::default()
            };
            scene.meshes.insert(MeshId(id), Arc::new(mesh));
            scene.materials.insert(MaterialId(id), material);
            let (mesh, material) = (MeshId(id), MaterialId(id));
            let instance = Instance { mesh, material, transform: Affine3A::IDENTITY };
            scene.instances.insert(InstanceId(id), instance);
        }
        let light = Light {
            kind: LightKind::Point,
            position: Vec3::new(0.3, 0.9, 0.6),
            direction: -Vec3::Y,
            intensity: Vec3::ONE,
            range: f32::INFINITY,
        };
        scene.lights.insert(LightId(0), light);
        World::new(&scene)
    }

    /// However early paths are ended, the mean stays the same.
    #[test]
    fn roulette_is_unbiased() {
        let world = tetrahedron();
        let origin = Vec3::splat(0.5);
        let mean = |roulette: Roulette, seed| {
            let n = 40_000_u32;
            let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
            let mut rng = Rng::new(seed, 0);
            for i in 0..n {
                // Independent numbers, so that the spread of single paths is the error.
                let mut sampler =
                    PathSampler::new(crate::sampling::hash_pair(seed, i.into()), 0, 0);
                let direction = uniform_sphere(rng.next_2d().into());
                let arriving = trace_path_with(&world, origin, direction, &mut sampler, roulette);
                let x = f64::from(arriving.indirect.element_sum());
                sum += x;
                squares += x * x;
            }
            let n = f64::from(n);
            (sum / n, ((squares / n - (sum / n).powi(2)) / n).sqrt())
        };
        let (truth, truth_se) = mean(Roulette { threshold: 1e-6, forced_after: 1000 }, 1);
        for (i, roulette) in [
            Roulette::STANDARD,
            Roulette { threshold: 1.0, forced_after: 24 },
            Roulette { threshold: 0.1, forced_after: 0 },
            Roulette { threshold: 3.0, forced_after: 0 },
        ]
        .into_iter()
        .enumerate()
        {
            let (found, se) = mean(roulette, 2 + i as u64);
            let z = (found - truth) / se.hypot(truth_se);
            assert!(z.abs() < 4.5, "{roulette:?}: {found} instead of {truth}, z = {z}");
            assert!(se < 0.02 * truth, "{roulette:?}: {found} +- {se}");
        }
    }

    /// Paths between perfect reflectors end.
    #[test]
    fn paths_end() {
        let survival = Roulette::STANDARD.survival(Vec3::splat(1e9), 25);
        assert!(survival <= 0.95);
        assert_eq!(Roulette::STANDARD.survival(Vec3::ONE, 1), 1.0);
        assert!((Roulette::STANDARD.survival(Vec3::splat(0.05), 1) - 0.5).abs() < 1e-6);
    }
}
