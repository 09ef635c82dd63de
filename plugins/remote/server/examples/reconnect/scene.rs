//! A small room made in code.

#![allow(dead_code, reason = "not everyone who includes this file needs all of it")]

use std::sync::Arc;

use farlight_gi_solver::{
    SceneChange,
    scene::{Instance, InstanceId, Light, LightId, LightKind, Material, MaterialId, Mesh, MeshId},
    session::{SessionChange, SessionSettings},
};
use glam::{Affine3A, Vec2, Vec3};

/// Settings under which the room is solved in a moment.
pub(crate) fn settings() -> SessionSettings {
    SessionSettings {
        page_size: 64,
        max_pages: 2,
        texels_per_metre: 4.0,
        rays_per_texel: 64,
        rays_per_probe: 64,
        ray_memory: 16 << 20,
        converged_paths: 0,
        ..SessionSettings::default()
    }
}

/// A closed room, `size` metres wide and deep and 3 m high, whose walls receive light, and a lamp.
pub(crate) fn room(size: f32) -> Vec<SessionChange> {
    let (x, y, z) = (Vec3::X * size, Vec3::Y * 3.0, Vec3::Z * size);
    let red = Vec3::new(0.7, 0.2, 0.15);
    let sides = [
        (Vec3::ZERO, z, x, Vec3::splat(0.6)),
        (y, x, z, Vec3::splat(0.8)),
        (Vec3::ZERO, y, z, red),
        (x, z, y, Vec3::splat(0.7)),
        (Vec3::ZERO, x, y, Vec3::splat(0.7)),
        (z, y, x, Vec3::splat(0.7)),
    ];
    let mut changes = Vec::new();
    for (id, (origin, u, v, albedo)) in (0..).zip(sides) {
        let mesh = Mesh {
            positions: vec![origin, origin + u, origin + u + v, origin + v],
            uv1: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        changes.extend(object(id, mesh, albedo));
        changes.push(SessionChange::AddReceiver(InstanceId(id)));
    }
    changes.push(lamp(Vec3::new(size / 2.0, 2.0, size / 2.0), 10.0));
    changes
}

/// A mesh as an instance with a material of its own.
fn object(id: u64, mesh: Mesh, albedo: Vec3) -> impl Iterator<Item = SessionChange> {
    let material = Material { base_color: albedo.extend(1.0), ..Material::default() };
    let instance =
        Instance { mesh: MeshId(id), material: MaterialId(id), transform: Affine3A::IDENTITY };
    [
        SceneChange::SetMesh(MeshId(id), Arc::new(mesh)),
        SceneChange::SetMaterial(MaterialId(id), material),
        SceneChange::SetInstance(InstanceId(id), instance),
    ]
    .into_iter()
    .map(SessionChange::Scene)
}

/// Places the lamp; `intensity` in W/sr.
pub(crate) fn lamp(position: Vec3, intensity: f32) -> SessionChange {
    SessionChange::Scene(SceneChange::SetLight(
        LightId(0),
        Light {
            kind: LightKind::Point,
            position,
            direction: Vec3::NEG_Z,
            intensity: Vec3::splat(intensity),
            range: f32::INFINITY,
        },
    ))
}

/// Rough ground below the room, of `edge * edge * 2` triangles: something heavy to send, different
/// for every seed.
pub(crate) fn ground(edge: u32, seed: u32) -> impl Iterator<Item = SessionChange> {
    let mut random = seed | 1;
    let mut height = move || {
        // xorshift32, Marsaglia 2003
        random ^= random << 13;
        random ^= random >> 17;
        random ^= random << 5;
        random as f32 / u32::MAX as f32
    };
    let row = edge + 1;
    let point = |i: u32| Vec3::new((i % row) as f32, 0.0, (i / row) as f32);
    let positions = (0..row * row).map(|i| point(i) - Vec3::Y * (1.0 + height())).collect();
    let triangles = (0..edge * edge).flat_map(|i| {
        let corner = i / edge * row + i % edge;
        let [right, down] = [corner + 1, corner + row];
        [[corner, down, right], [right, down, down + 1]]
    });
    let mesh = Mesh { positions, triangles: triangles.collect(), ..Mesh::default() };
    object(100, mesh, Vec3::splat(0.5))
}
