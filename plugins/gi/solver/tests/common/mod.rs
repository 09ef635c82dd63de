//! Scenes made by hand.

#![allow(dead_code, reason = "not every test uses every helper")]

use std::sync::Arc;

use farlight_gi_solver::{
    SceneChange,
    scene::{Instance, InstanceId, Light, LightId, LightKind, Material, MaterialId, Mesh, MeshId},
    session::{LightingUpdate, Session, SessionChange, SessionSettings, SnapshotId},
};
use glam::{Affine3A, Vec2, Vec3};

/// Changes that make up a scene; ids count up from 0.
#[derive(Default)]
pub(crate) struct Builder {
    pub(crate) changes: Vec<SessionChange>,
    next: u64,
}

/// A parallelogram from `origin` along `u` and `v`, facing `u x v`, its second UV set 0..1.
pub(crate) fn quad(origin: Vec3, u: Vec3, v: Vec3) -> Mesh {
    Mesh {
        positions: vec![origin, origin + u, origin + u + v, origin + v],
        uv1: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    }
}

impl Builder {
    /// A builder whose ids do not meet those of another.
    pub(crate) fn starting_at(next: u64) -> Self {
        Self { changes: Vec::new(), next }
    }

    /// Adds a mesh as an instance with its own material; a receiver if it has a second UV set.
    pub(crate) fn add(&mut self, mesh: Mesh, albedo: Vec3, emissive: Vec3) -> InstanceId {
        let id = self.next;
        self.next += 1;
        let receiver = !mesh.uv1.is_empty();
        let material = Material { base_color: albedo.extend(1.0), emissive, ..Default::default() };
        let instance =
            Instance { mesh: MeshId(id), material: MaterialId(id), transform: Affine3A::IDENTITY };
        for change in [
            SceneChange::SetMesh(MeshId(id), Arc::new(mesh)),
            SceneChange::SetMaterial(MaterialId(id), material),
            SceneChange::SetInstance(InstanceId(id), instance),
        ] {
            self.changes.push(SessionChange::Scene(change));
        }
        if receiver {
            self.changes.push(SessionChange::AddReceiver(InstanceId(id)));
        }
        InstanceId(id)
    }

    /// Adds a quad.
    pub(crate) fn quad(&mut self, origin: Vec3, u: Vec3, v: Vec3, albedo: Vec3) -> InstanceId {
        self.add(quad(origin, u, v), albedo, Vec3::ZERO)
    }

    /// Six quads that face inwards: floor, ceiling, -x, +x, -z, +z.
    pub(crate) fn room(&mut self, low: Vec3, high: Vec3, albedo: [Vec3; 6], emissive: Vec3) {
        let d = high - low;
        let (x, y, z) = (Vec3::X * d.x, Vec3::Y * d.y, Vec3::Z * d.z);
        let sides = [
            (low, z, x),
            (low + y, x, z),
            (low, y, z),
            (low + x, z, y),
            (low, x, y),
            (low + z, y, x),
        ];
        for ((origin, u, v), albedo) in sides.into_iter().zip(albedo) {
            self.add(quad(origin, u, v), albedo, emissive);
        }
    }

    /// Adds a point light.
    pub(crate) fn point_light(&mut self, id: u64, position: Vec3, intensity: Vec3) {
        self.changes.push(set_light(id, position, intensity));
    }

    /// A session with the scene.
    pub(crate) fn session(self, settings: SessionSettings) -> Session {
        let mut session = Session::new(settings);
        session.apply(SnapshotId(1), self.changes);
        session
    }
}

/// A change that places a point light.
pub(crate) fn set_light(id: u64, position: Vec3, intensity: Vec3) -> SessionChange {
    SessionChange::Scene(SceneChange::SetLight(
        LightId(id),
        Light {
            kind: LightKind::Point,
            position,
            direction: Vec3::NEG_Z,
            intensity,
            range: f32::INFINITY,
        },
    ))
}

/// Steps until the session is idle; all updates.
pub(crate) fn settle(session: &mut Session) -> Vec<LightingUpdate> {
    let mut updates = Vec::new();
    for _ in 0..100_000 {
        updates.extend(session.step());
        if session.is_idle() {
            return updates;
        }
    }
    panic!("the session never becomes idle");
}

/// Small settings, quick in tests.
pub(crate) fn small() -> SessionSettings {
    SessionSettings {
        page_size: 128,
        max_pages: 1,
        texels_per_metre: 4.0,
        rays_per_texel: 256,
        rays_per_probe: 256,
        converged_paths: 0,
        ..Default::default()
    }
}

/// Two rooms along x with a wall between them; `door` cuts a doorway. Room 1 is x 0..4, room 2 is
/// x 4.2..8.2, both z 0..4, y 0..3. The doorway is z 1.5..2.5, y 0..2.
pub(crate) fn two_rooms(door: bool) -> Builder {
    let mut b = Builder::default();
    let grey = Vec3::splat(0.7);
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    for (x0, wall, open_wall) in
        [(0.0, Vec3::new(0.7, 0.2, 0.15), 4.0), (4.2, Vec3::new(0.2, 0.3, 0.7), 4.2)]
    {
        let o = x * x0;
        b.quad(o, z * 4.0, x * 4.0, Vec3::new(0.55, 0.42, 0.3)); // floor
        b.quad(o + y * 3.0, x * 4.0, z * 4.0, Vec3::splat(0.8)); // ceiling
        b.quad(o, x * 4.0, y * 3.0, grey); // -z
        b.quad(o + z * 4.0, y * 3.0, x * 4.0, grey); // +z
        let far = if x0 == 0.0 { 0.0 } else { 8.2 };
        let flip = x0 != 0.0;
        let mut wall_quad = |origin: Vec3, h: Vec3, w: Vec3, flip: bool, albedo: Vec3| {
            if flip { b.quad(origin, w, h, albedo) } else { b.quad(origin, h, w, albedo) }
        };
        wall_quad(x * far, y * 3.0, z * 4.0, flip, wall);
        let at = x * open_wall;
        if door {
            wall_quad(at, y * 3.0, z * 1.5, !flip, grey);
            wall_quad(at + z * 2.5, y * 3.0, z * 1.5, !flip, grey);
            wall_quad(at + z * 1.5 + y * 2.0, y, z, !flip, grey);
        } else {
            wall_quad(at, y * 3.0, z * 4.0, !flip, grey);
        }
    }
    if door {
        let o = Vec3::new(4.0, 0.0, 1.5);
        let depth = x * 0.2;
        b.quad(o, z, depth, grey); // sill
        b.quad(o + y * 2.0, depth, z, grey); // lintel
        b.quad(o, depth, y * 2.0, grey);
        b.quad(o + z, y * 2.0, depth, grey);
    }
    b
}
