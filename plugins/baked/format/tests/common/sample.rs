//! A manifest with something of everything.

use farlight_baked_format::{
    Fingerprint, Manifest,
    manifest::{
        Direct, LeftOut, Light, LightKind, Page, Receiver, Scenario, Settings, VERSION, Volume,
    },
};
use glam::{Affine3A, UVec3, Vec3};

/// A room with two scenarios and as many receivers as asked for.
pub(crate) fn manifest(receivers: u32) -> Manifest {
    let receiver = |i: u32| Receiver {
        node: 5 + i,
        primitive: 1,
        name: format!("Chair \"{i}\""),
        page: i % 2,
        rect: [i % 500, 2, 12, 7],
        uv: Fingerprint::of(&i.to_le_bytes()),
    };
    Manifest {
        version: VERSION,
        scene: "room.glb".to_owned(),
        input: Fingerprint::of(b"all"),
        complete: true,
        settings: Settings {
            scale: 0.001,
            texels_per_metre: 57.25,
            samples: 256,
            bounces: 0,
            denoise: true,
            seed: u64::MAX,
        },
        page_size: 512,
        pages: 2,
        receivers: (0..receivers).map(receiver).collect(),
        left_out: vec![LeftOut {
            node: 1,
            primitive: 0,
            name: "Cables".to_owned(),
            reason: "lines have no area".to_owned(),
        }],
        volumes: vec![Volume::new(
            &Affine3A::from_scale(Vec3::new(6.5, 2.75, 4.0)),
            UVec3::new(12, 6, 8),
        )],
        scenarios: vec![scenario("day", vec![sun()]), scenario("lamp", vec![sun(), lamp()])],
    }
}

fn scenario(name: &str, lights: Vec<Light>) -> Scenario {
    let page = |page: u32, end: &str| format!("room.{name}.{page}.0badc0de.{end}");
    Scenario {
        name: name.to_owned(),
        pages: (0..2).map(|i| Page { ktx2: page(i, "ktx2"), exr: page(i, "exr") }).collect(),
        volumes: vec![format!("room.{name}.volume0.0badc0de.ktx2")],
        lights,
        sky: [1.0, 2.0, 1000.0 / 3.0],
        samples: 256,
        relative_error: 0.0375,
    }
}

fn sun() -> Light {
    Light {
        node: Some(9),
        name: "Sun".to_owned(),
        direct: Direct::Realtime,
        kind: LightKind::Directional,
        position: [0.0; 3],
        direction: [0.0, -0.6, 0.8],
        intensity: [20_000.0, 19_000.0, 18_000.0],
        range: 0.0,
        radius: 0.004_65,
    }
}

fn lamp() -> Light {
    Light {
        node: None,
        name: "Lamp".to_owned(),
        direct: Direct::Baked,
        kind: LightKind::Spot { inner: 0.3, outer: 0.6 },
        position: [1.0, 2.0, -0.25],
        direction: [0.0, -1.0, 0.0],
        intensity: [120.0, 100.0, 60.0],
        range: 20.0,
        radius: 0.05,
    }
}
