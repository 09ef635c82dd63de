//! Materials with holes.

use std::{f32::consts::PI, sync::Arc};

use farlight_gi_solver::{
    Ray,
    estimate::no_progress,
    path::PathTracer,
    receiver::Receiver,
    scene::{AlphaMode, Material, Texture, TextureId},
};
use glam::Vec3;

use crate::{
    build::{Build, diffuse, point, quad},
    check::{agrees, paths},
};

/// A large curtain at height 1: transparent where x < 0, a material of albedo ρ where x > 0.
fn curtain(layers: u32, rho: f32) -> Build {
    let mut build = Build::default();
    let texture = Texture {
        width: 2,
        height: 1,
        texels: vec![[255, 255, 255, 0], [255, 255, 255, 255]],
        srgb: false,
    };
    build.scene.textures.insert(TextureId(0), Arc::new(texture));
    for layer in 0..layers {
        let height = 1.0 + layer as f32 * 0.01;
        // u runs from 0.25 to 0.75, the centres of the texels, so that alpha is 1/2 at x = 0.
        let mut mesh = quad(Vec3::new(-9.0, height, -9.0), Vec3::X * 18.0, Vec3::Z * 18.0);
        mesh.uv0.iter_mut().for_each(|uv| uv.x = 0.25 + uv.x * 0.5);
        let material = Material {
            base_color_texture: Some(TextureId(0)),
            alpha_mode: AlphaMode::Mask(0.5),
            ..diffuse(Vec3::splat(rho))
        };
        build = build.mesh(mesh, material);
    }
    build
}

#[test]
fn shadow_rays_pass_through_holes_only() {
    for layers in 1..=3 {
        let world = curtain(layers, 0.5).light(point(Vec3::Y * 3.0, Vec3::ONE)).world();
        assert!(world.has_masks());
        for i in 0..40 {
            let x = i as f32 * 0.1 - 1.95;
            let receiver = Receiver { position: Vec3::new(x, 0.0, 0.3), normal: Vec3::Y };
            assert_eq!(receiver.direct(&world).x > 0.0, x < 0.0, "x = {x}, {layers} layers");
            let up = Ray::new(receiver.position, Vec3::Y);
            assert_eq!(world.closest(&up).is_hit(), x > 0.0);
            assert_eq!(world.occluded(&up), x > 0.0);
        }
    }
}

/// Below the edge of the curtain half the sky is seen (the curtain is so large that beyond it there
/// is next to nothing), the other half is hidden.
#[test]
fn paths_pass_through_holes() {
    let world = curtain(3, 0.0).sky(Vec3::ONE).world();
    let receiver = Receiver { position: Vec3::new(0.0, 0.98, 0.0), normal: Vec3::Y };
    let light = receiver.gather(&PathTracer::new(&world), &paths(8192), 0, no_progress()).unwrap();
    // Beyond 9 m at 2 cm below: less than (0.02 / 9)² of the hemisphere's projection.
    agrees("half the sky", light.direct, Vec3::splat(PI / 2.0), 1e-4);
    assert_eq!(light.indirect.mean, Vec3::ZERO);
}

#[test]
fn worlds_without_holes_say_so() {
    let world =
        Build::default().mesh(quad(Vec3::ZERO, Vec3::X, Vec3::Z), Material::default()).world();
    assert!(!world.has_masks());
}
