//! Points on surfaces that emit.

use glam::{Vec2, Vec3};

use super::table::Table;
use crate::{Hit, World, sampling::PathSampler, scene::AlphaMode};

/// All triangles that may emit, drawn by area times (roughly) their radiance.
#[derive(Default)]
pub(super) struct Emitters {
    table: Table,
    /// Triangle of each entry of the table.
    triangles: Vec<u32>,
    /// Probability density per area of each triangle of the world; empty if nothing emits.
    per_area: Vec<f32>,
}

/// A point on an emitter, as seen from somewhere.
pub(super) struct EmitterSample {
    /// From there to the point, in metres.
    pub(super) offset: Vec3,
    /// Unit direction of `offset`.
    pub(super) direction: Vec3,
    /// What the point emits.
    pub(super) radiance: Vec3,
    /// Density per solid angle with which it is drawn.
    pub(super) pdf: f32,
}

impl Emitters {
    pub(super) fn new(world: &World) -> Self {
        let mut emitters = Self::default();
        let mut brightness = Vec::new();
        for instance in world.instances() {
            let brightest = instance.material.emissive.max_element();
            if !(brightest > 0.0 && brightest.is_finite()) {
                continue;
            }
            let first = instance.first_triangle;
            for triangle in first..first + instance.mesh.triangles.len() as u32 {
                emitters.triangles.push(triangle);
                brightness.push(mean_brightness(world, triangle).max(0.1 * brightest));
            }
        }
        if emitters.triangles.is_empty() {
            return emitters;
        }
        let area = |triangle| {
            let [a, b, c] = world.corners(triangle);
            0.5 * (b - a).cross(c - a).length()
        };
        emitters.table =
            Table::new(emitters.triangles.iter().zip(&brightness).map(|(t, b)| area(*t) * b));
        let total = emitters.table.total();
        emitters.per_area = vec![0.0; world.triangle_count()];
        for (triangle, brightness) in emitters.triangles.iter().zip(&brightness) {
            // weight / total / area, with weight = area * brightness.
            if area(*triangle) > 0.0 && total > 0.0 {
                emitters.per_area[*triangle as usize] = (f64::from(*brightness) / total) as f32;
            }
        }
        emitters
    }

    pub(super) fn is_empty(&self) -> bool {
        self.table.is_empty()
    }

    /// Draws a point. `None` if nothing arrives from it.
    pub(super) fn sample(
        &self,
        world: &World,
        from: Vec3,
        sampler: &mut PathSampler,
    ) -> Option<EmitterSample> {
        let (entry, u) = self.table.sample(sampler);
        let triangle = self.triangles[entry];
        let surface = world.surface_at(triangle, uniform_triangle(u), false);
        let cut_out = match world.instances()[surface.instance as usize].material.alpha_mode {
            AlphaMode::Mask(cutoff) => surface.alpha < cutoff,
            _ => false,
        };
        if cut_out || surface.emission == Vec3::ZERO {
            return None;
        }
        let offset = surface.position - from;
        let direction = offset.normalize_or_zero();
        let pdf = self.pdf(triangle, offset.length_squared(), surface.normal.dot(direction));
        (pdf > 0.0 && pdf.is_finite()).then_some(EmitterSample {
            offset,
            direction,
            radiance: surface.emission,
            pdf,
        })
    }

    /// Density per solid angle with which [`sample`](Self::sample) draws a point that a ray with a
    /// unit direction met.
    pub(super) fn pdf_of_hit(&self, hit: &Hit, cos: f32) -> f32 {
        if self.per_area.is_empty() { 0.0 } else { self.pdf(hit.triangle, hit.t * hit.t, cos) }
    }

    fn pdf(&self, triangle: u32, distance_squared: f32, cos: f32) -> f32 {
        self.per_area[triangle as usize] * distance_squared / cos.abs()
    }
}

/// Mean largest channel of a triangle's emission at a few points.
fn mean_brightness(world: &World, triangle: u32) -> f32 {
    let points = [(1.0, 1.0), (4.0, 1.0), (1.0, 4.0), (2.0, 2.0)];
    points
        .map(|(u, v)| world.surface_at(triangle, Vec2::new(u, v) / 6.0, false).emission)
        .map(Vec3::max_element)
        .iter()
        .sum::<f32>()
        / points.len() as f32
}

/// Barycentric weights of the second and third corner of a uniformly drawn point (Turk 1990).
fn uniform_triangle(u: Vec2) -> Vec2 {
    let root = u.x.sqrt();
    Vec2::new(root * (1.0 - u.y), root * u.y)
}
