//! Small scenes with known answers.

use std::sync::Arc;

use farlight_gi_solver::{
    Scene, World,
    scene::{
        Instance, InstanceId, Light, LightId, LightKind, Material, MaterialId, Mesh, MeshId, Sky,
    },
};
use glam::{Affine3A, Vec3, Vec4};

/// Collects meshes, one material each, and lights.
#[derive(Default)]
pub(crate) struct Build {
    pub(crate) scene: Scene,
}

impl Build {
    /// Adds a mesh with a material.
    pub(crate) fn mesh(mut self, mesh: Mesh, material: Material) -> Self {
        let id = self.scene.meshes.len() as u64;
        self.scene.meshes.insert(MeshId(id), Arc::new(mesh));
        self.scene.materials.insert(MaterialId(id), material);
        self.scene.instances.insert(
            InstanceId(id),
            Instance { mesh: MeshId(id), material: MaterialId(id), transform: Affine3A::IDENTITY },
        );
        self
    }

    /// Adds a light.
    pub(crate) fn light(mut self, light: Light) -> Self {
        let id = self.scene.lights.len() as u64;
        self.scene.lights.insert(LightId(id), light);
        self
    }

    /// Sets a sky of constant radiance.
    pub(crate) fn sky(mut self, radiance: Vec3) -> Self {
        self.scene.sky = Sky::Constant(radiance);
        self
    }

    /// The flattened scene.
    pub(crate) fn world(&self) -> World {
        World::new(&self.scene)
    }
}

/// A diffuse reflector.
pub(crate) fn diffuse(albedo: Vec3) -> Material {
    Material { base_color: albedo.extend(1.0), ..Material::default() }
}

/// A diffuse reflector that emits.
pub(crate) fn emitter(albedo: Vec3, emissive: Vec3) -> Material {
    Material { emissive, ..diffuse(albedo) }
}

/// A black surface.
pub(crate) fn black() -> Material {
    Material { base_color: Vec4::new(0.0, 0.0, 0.0, 1.0), ..Material::default() }
}

/// A point light of equal intensity in all directions.
pub(crate) fn point(position: Vec3, intensity: Vec3) -> Light {
    Light { kind: LightKind::Point, position, direction: -Vec3::Y, intensity, range: f32::INFINITY }
}

/// A light from infinitely far away, travelling along `direction`.
pub(crate) fn directional(direction: Vec3, irradiance: Vec3) -> Light {
    Light {
        kind: LightKind::Directional,
        position: Vec3::ZERO,
        direction: direction.normalize(),
        intensity: irradiance,
        range: f32::INFINITY,
    }
}

/// A parallelogram with first UV set 0..1 along its edges; its front side is that of `u × v`.
pub(crate) fn quad(corner: Vec3, u: Vec3, v: Vec3) -> Mesh {
    use glam::Vec2;
    Mesh {
        positions: vec![corner, corner + u, corner + u + v, corner + v],
        uv0: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A regular polygon with so many corners that it stands for a disc (its area is right to 3e-5).
pub(crate) fn disc(centre: Vec3, normal: Vec3, radius: f32) -> Mesh {
    let n = 512_u32;
    let tangent = normal.any_orthonormal_vector();
    let bitangent = normal.cross(tangent);
    let mut positions = vec![centre];
    positions.extend((0..n).map(|i| {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / n as f32).sin_cos();
        centre + (tangent * cos + bitangent * sin) * radius
    }));
    let triangles = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// A sphere: an octahedron subdivided, normals outward. Cross section and area are right to about
/// 3e-4 because the corners lie a little outside the radius.
pub(crate) fn sphere(centre: Vec3, radius: f32) -> Mesh {
    const STEPS: usize = 48;
    // How far the flat faces stay inside, on average, for this number of steps.
    const BULGE: f32 = 1.0 + 1.8e-4;
    let mut mesh = Mesh::default();
    for octant in 0..8 {
        let sign = Vec3::new(
            if octant & 1 == 0 { 1.0 } else { -1.0 },
            if octant & 2 == 0 { 1.0 } else { -1.0 },
            if octant & 4 == 0 { 1.0 } else { -1.0 },
        );
        let mirrored = sign.x * sign.y * sign.z < 0.0;
        // Great-circle subdivision by interpolated angles keeps the faces nearly equal.
        let corner = |i: usize, j: usize| {
            let (a, b) = (i as f32 / STEPS as f32, j as f32 / STEPS as f32);
            let c = 1.0 - a - b;
            let ease = |x: f32| (x * std::f32::consts::FRAC_PI_2).sin();
            centre + sign * Vec3::new(ease(a), ease(b), ease(c)).normalize() * (radius * BULGE)
        };
        for i in 0..STEPS {
            for j in 0..STEPS - i {
                let mut face = |a: Vec3, b: Vec3, c: Vec3| {
                    let first = mesh.positions.len() as u32;
                    mesh.positions.extend([a, b, c]);
                    mesh.triangles.push(if mirrored {
                        [first, first + 2, first + 1]
                    } else {
                        [first, first + 1, first + 2]
                    });
                };
                face(corner(i, j), corner(i + 1, j), corner(i, j + 1));
                if i + j + 1 < STEPS {
                    face(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
                }
            }
        }
    }
    mesh
}

/// The inside of an axis-aligned box: six quads whose front sides look inwards.
pub(crate) fn room(min: Vec3, max: Vec3) -> [Mesh; 6] {
    let d = max - min;
    let (x, y, z) = (Vec3::X * d.x, Vec3::Y * d.y, Vec3::Z * d.z);
    [
        quad(min, z, x),
        quad(min + y, x, z),
        quad(min, x, y),
        quad(min + z, y, x),
        quad(min, y, z),
        quad(min + x, z, y),
    ]
}
