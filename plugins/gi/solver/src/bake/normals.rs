//! Normals of smooth surfaces.

use glam::{Mat3A, Vec3};

use crate::{
    World,
    lightmap::{Patches, SurfacePoint},
    world::WorldInstance,
};

/// Normals that differ by less than this cosine from that of their triangle are that.
const FLAT: f32 = 0.999_99;
/// Shading normals keep at least this cosine to the normal of their triangle.
const LEAST: f32 = 0.05;

/// The unit shading normal of each texel of a receiver.
pub(super) fn shading_normals(world: &World, patches: &Patches) -> Vec<Vec3> {
    let mut normals = patches.normal[..patches.fronts].to_vec();
    for receiver in &patches.receivers {
        let instance = &world.instances()[receiver.instance as usize];
        let smooth = Smooth::new(instance);
        for i in 0..receiver.texels.len() {
            let texel = receiver.first as usize + i;
            // The texel's point may have moved to one of its sample points.
            let position = patches.position[texel];
            let moved = patches.samples[texel].iter().position(|s| *s == position);
            let local = |p: SurfacePoint| SurfacePoint {
                triangle: p.triangle - instance.first_triangle,
                ..p
            };
            let point =
                moved.map_or(receiver.texels.points[i], |k| local(patches.points[texel][k]));
            normals[texel] = smooth.normal(point, patches.normal[texel]);
        }
    }
    normals
}

/// The normals of an instance's vertices, in the world.
pub(super) struct Smooth<'a> {
    instance: &'a WorldInstance,
    /// From normals in the mesh's space to the world. Mirroring doesn't turn them over: the front of a
    /// mirrored triangle is where it was.
    matrix: Mat3A,
}

impl<'a> Smooth<'a> {
    pub(super) fn new(instance: &'a WorldInstance) -> Self {
        Self { instance, matrix: instance.transform.matrix3.inverse().transpose() }
    }

    /// The shading normal at a point of the mesh, on the side of the triangle's unit normal `geometric`.
    pub(super) fn normal(&self, point: SurfacePoint, geometric: Vec3) -> Vec3 {
        let mesh = &self.instance.mesh;
        if mesh.normals.is_empty() {
            return geometric;
        }
        let [a, b, c] = mesh.triangles[point.triangle as usize].map(|i| mesh.normals[i as usize]);
        let local = a * (1.0 - point.bary.x - point.bary.y) + b * point.bary.x + c * point.bary.y;
        let normal = (self.matrix * local).normalize_or_zero();
        let cos = normal.dot(geometric);
        if !normal.is_finite() || cos > FLAT || cos <= -0.5 {
            // Flat; or turned over, as some exporters do with what they mirror.
            geometric
        } else if cos < LEAST {
            (normal + geometric * (LEAST - cos)).normalize()
        } else {
            normal
        }
    }

    /// The shading normal at a point, given with the world's triangle, and how far it lies below the
    /// curved surface that the vertices' normals stand for: each vertex lifts it to its tangent plane
    /// (Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II). Flat and hollow surfaces aren't
    /// lifted.
    pub(super) fn at(&self, point: SurfacePoint, geometric: Vec3) -> (Vec3, Vec3) {
        let triangle = point.triangle - self.instance.first_triangle;
        let point = SurfacePoint { triangle, ..point };
        let normal = self.normal(point, geometric);
        let lift = if normal == geometric { Vec3::ZERO } else { self.lift(point) };
        (normal, lift)
    }

    fn lift(&self, point: SurfacePoint) -> Vec3 {
        let mesh = &self.instance.mesh;
        let corners = mesh.triangles[point.triangle as usize].map(|i| i as usize);
        let to_world = |p: Vec3| self.instance.transform.transform_point3(p);
        let weights = [1.0 - point.bary.x - point.bary.y, point.bary.x, point.bary.y];
        let places = corners.map(|i| to_world(mesh.positions[i]));
        let position: Vec3 = places.iter().zip(weights).map(|(p, w)| *p * w).sum();
        let mut lift = Vec3::ZERO;
        for ((place, corner), weight) in places.iter().zip(corners).zip(weights) {
            let normal = (self.matrix * mesh.normals[corner]).normalize_or_zero();
            let depth = (position - *place).dot(normal).min(0.0);
            lift -= normal * (depth * weight);
        }
        if lift.is_finite() { lift } else { Vec3::ZERO }
    }
}
