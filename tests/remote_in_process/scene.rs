//! A small room, and what a local session makes of it.

use std::{collections::BTreeMap, sync::Arc};

use bevy::math::{Affine3A, UVec3, Vec2, Vec3};
use farlight::gi::solver::{
    SceneChange,
    scene::{Instance, InstanceId, Light, LightId, LightKind, Material, MaterialId, Mesh, MeshId},
    session::{GridId, ProbeGrid, Session, SessionChange, SessionSettings, SnapshotId},
};

use crate::picture::Picture;

/// The probes of the room.
pub(crate) const GRID: GridId = GridId(100);

/// Quick to solve, and good enough to tell one light from another.
pub(crate) fn settings() -> SessionSettings {
    SessionSettings {
        page_size: 64,
        max_pages: 1,
        texels_per_metre: 4.0,
        rays_per_texel: 256,
        rays_per_probe: 256,
        converged_paths: 0,
        ..Default::default()
    }
}

/// A parallelogram from `origin` along `u` and `v`, facing `u x v`, its second UV set 0..1.
fn quad(origin: Vec3, u: Vec3, v: Vec3) -> Mesh {
    Mesh {
        positions: vec![origin, origin + u, origin + u + v, origin + v],
        uv1: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    }
}

/// A closed room of 4 x 3 x 4 m without a light, and probes in it.
pub(crate) fn room() -> Vec<SessionChange> {
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 3.0, Vec3::Z * 4.0);
    let sides = [
        (Vec3::ZERO, z, x, Vec3::new(0.6, 0.5, 0.4)),
        (y, x, z, Vec3::splat(0.8)),
        (Vec3::ZERO, y, z, Vec3::new(0.7, 0.2, 0.2)),
        (x, z, y, Vec3::new(0.2, 0.3, 0.7)),
        (Vec3::ZERO, x, y, Vec3::splat(0.7)),
        (z, y, x, Vec3::splat(0.7)),
    ];
    let mut changes = Vec::new();
    for (id, (origin, u, v, albedo)) in (0_u64..).zip(sides) {
        let material = Material { base_color: albedo.extend(1.0), ..Default::default() };
        let (mesh, transform) = (MeshId(id), Affine3A::IDENTITY);
        let instance = Instance { mesh, material: MaterialId(id), transform };
        changes.extend(
            [
                SceneChange::SetMesh(mesh, Arc::new(quad(origin, u, v))),
                SceneChange::SetMaterial(MaterialId(id), material),
                SceneChange::SetInstance(InstanceId(id), instance),
            ]
            .map(SessionChange::Scene),
        );
        changes.push(SessionChange::AddReceiver(InstanceId(id)));
    }
    let transform = Affine3A::from_scale_rotation_translation(
        Vec3::new(3.0, 2.0, 3.0),
        Default::default(),
        Vec3::new(2.0, 1.5, 2.0),
    );
    changes
        .push(SessionChange::SetGrid(GRID, ProbeGrid { transform, resolution: UVec3::splat(3) }));
    changes
}

/// Moves the lamp through the room and changes its colour with it; `phase` 0 and 1 differ much.
pub(crate) fn lamp(phase: f32) -> SessionChange {
    let light = Light {
        kind: LightKind::Point,
        position: Vec3::new(0.7 + 2.6 * phase, 1.5, 1.0 + 2.0 * phase),
        direction: Vec3::NEG_Z,
        intensity: Vec3::new(100.0, 60.0 + 40.0 * phase, 100.0 - 60.0 * phase),
        range: f32::INFINITY,
    };
    SessionChange::Scene(SceneChange::SetLight(LightId(0), light))
}

/// What a session in this process shows when it has converged.
pub(crate) fn local(phase: f32) -> Picture {
    let mut session = Session::new(settings());
    let mut changes = room();
    changes.push(lamp(phase));
    session.apply(SnapshotId(1), changes);
    let mut picture = Picture::default();
    while !session.is_idle() {
        if let Some(update) = session.step() {
            picture.show(farlight::gi::GiUpdate::encode(&update));
        }
    }
    picture
}

/// Local pictures by hundredths of the phase, made once.
#[derive(Default)]
pub(crate) struct Locals(BTreeMap<u32, Picture>);

impl Locals {
    pub(crate) fn get(&mut self, phase: f32) -> &Picture {
        self.0.entry((phase * 100.0).round() as u32).or_insert_with(|| local(phase))
    }
}
