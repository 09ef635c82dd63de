//! A closed room with one lamp, as changes for a backend.

use std::sync::Arc;

use bevy::math::{Affine3A, Vec2, Vec3};
use farlight::gi::{
    GiSettings,
    solver::{
        SceneChange,
        scene::{
            Instance, InstanceId, Light, LightId, LightKind, Material, MaterialId, Mesh, MeshId,
        },
        session::SessionChange,
    },
};

/// Walls, each with a lightmap.
pub const WALLS: usize = 6;
/// Half the edge of the room in metres.
const HALF: f32 = 1.5;
/// Reflectance of all walls.
const ALBEDO: f32 = 0.5;

/// Settings with which the room converges in well under a second.
pub fn settings() -> GiSettings {
    GiSettings {
        page_size: 64,
        max_pages: 1,
        texels_per_metre: 4.0,
        rays_per_texel: 64,
        rays_per_probe: 64,
        converged_paths: 64,
        ..GiSettings::default()
    }
}

/// The room, its six walls with lightmaps, and the lamp.
pub fn room(intensity: f32) -> Vec<SessionChange> {
    let mut changes = vec![
        SessionChange::Scene(SceneChange::SetMesh(MeshId(1), Arc::new(wall()))),
        SessionChange::Scene(SceneChange::SetMaterial(
            MaterialId(1),
            Material { base_color: Vec3::splat(ALBEDO).extend(1.0), ..Material::default() },
        )),
    ];
    let sides: [Vec3; WALLS] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    for (id, outward) in (1..).zip(sides) {
        let rotation = bevy::math::Quat::from_rotation_arc(Vec3::Z, -outward);
        let transform = Affine3A::from_rotation_translation(rotation, outward * HALF);
        let instance = Instance { mesh: MeshId(1), material: MaterialId(1), transform };
        changes.push(SessionChange::Scene(SceneChange::SetInstance(InstanceId(id), instance)));
        changes.push(SessionChange::AddReceiver(InstanceId(id)));
    }
    changes.push(lamp(intensity));
    changes
}

/// Sets the lamp's intensity in candela.
pub fn lamp(intensity: f32) -> SessionChange {
    let light = Light {
        kind: LightKind::Point,
        position: Vec3::new(0.3, 0.4, -0.2),
        direction: Vec3::NEG_Z,
        intensity: Vec3::splat(intensity),
        range: f32::INFINITY,
    };
    SessionChange::Scene(SceneChange::SetLight(LightId(1), light))
}

/// A square wall in the plane z = 0 that faces +z.
fn wall() -> Mesh {
    let corner = |u: f32, v: f32| Vec3::new(2.0 * u - 1.0, 2.0 * v - 1.0, 0.0) * HALF;
    Mesh {
        positions: vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)],
        uv1: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}
