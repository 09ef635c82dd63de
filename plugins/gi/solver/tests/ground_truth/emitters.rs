//! Small and bright things: emitters and suns that chance would seldom meet.

use std::{
    f32::consts::{PI, TAU},
    sync::Arc,
};

use farlight_gi_solver::{
    estimate::{Estimate, no_progress},
    path::PathTracer,
    probe::gather_probe,
    receiver::Receiver,
    scene::{Sky, SkyImage},
    sh::sh_basis,
};
use glam::{Quat, Vec3};

use crate::{
    build::{Build, diffuse, disc, emitter, room, sphere},
    check::{agrees, paths, sharp},
};

/// A coin at one metre: E = π L r² / (r² + h²), of which chance would meet ten in 4096.
#[test]
fn glowing_coin() {
    let (radius, emitted) = (0.05_f32, Vec3::new(100.0, 50.0, 10.0));
    let world =
        Build::default().mesh(disc(Vec3::Y, Vec3::Y, radius), emitter(Vec3::ZERO, emitted)).world();
    let tracer = PathTracer::new(&world);
    let receiver = Receiver { position: Vec3::ZERO, normal: Vec3::Y };
    let light = receiver.gather(&tracer, &paths(4096), 0, no_progress()).unwrap();
    let squared = radius * radius;
    agrees("coin", light.indirect, PI * emitted * squared / (squared + 1.0), 1e-4);
    sharp("coin", light.indirect, 0.002);

    let probe = gather_probe(&tracer, Vec3::ZERO, &paths(4096), 0, no_progress()).unwrap();
    let cos = 1.0 / (squared + 1.0).sqrt();
    // 1 - cos θ without cancellation.
    let cap = TAU * squared / (squared + 1.0) / (1.0 + cos);
    let first = Estimate { mean: probe.indirect.0[0], se: probe.indirect_se.0[0] };
    agrees("probe and coin", first, emitted * (sh_basis(Vec3::Y)[0] * cap), 1e-4);
    sharp("probe and coin", first, 0.01);
}

/// A small glowing ball in an integrating sphere: what it emits, 4π² r² L, is absorbed by the wall
/// and by the ball itself, which stops the fraction of the light that meets it. To the wall: with
/// f = (r/R)² the fraction of the wall's light that meets the ball (convex inside a sphere of even
/// light), E 4πR² = Φ + E 4πR² (ρ (1 - f) + ρ f ρ_ball).
#[test]
fn glowing_ball_in_a_sphere() {
    let (radius, ball) = (2.0_f32, 0.1_f32);
    let (rho, rho_ball) = (Vec3::new(0.3, 0.5, 0.7), Vec3::new(0.5, 0.0, 0.9));
    let emitted = Vec3::new(100.0, 200.0, 50.0);
    let world = Build::default()
        .mesh(sphere(Vec3::ZERO, radius), diffuse(rho))
        .mesh(sphere(Vec3::ZERO, ball), emitter(rho_ball, emitted))
        .world();
    let tracer = PathTracer::new(&world);
    let f = (ball / radius).powi(2);
    let first = PI * emitted * f;
    let truth = first / (Vec3::ONE - rho * (1.0 - f) - rho * f * rho_ball);
    for i in 0..3 {
        let third = glam::Vec2::splat(1.0 / 3.0);
        let surface = world.surface_at(100 + 900 * i, third, false);
        let normal = -surface.position.normalize();
        let receiver = Receiver { position: surface.position, normal };
        let light = receiver.gather(&tracer, &paths(8192), i.into(), no_progress()).unwrap();
        agrees("ball", light.indirect, truth, 2e-3);
        sharp("ball", light.indirect, 0.015);
    }
}

/// A sun of one texel over a plane, and what a room with a hole in its roof makes of it.
#[test]
fn sun_in_a_sky_image() {
    let (width, height) = (64_u32, 32_u32);
    let (column, row) = (40, 6);
    let mut texels = vec![Vec3::new(0.2, 0.3, 0.5); (width * height) as usize];
    let sun = Vec3::new(5000.0, 4000.0, 3000.0);
    texels[(row * width + column) as usize] = sun;
    let build = Build::default();
    let with_sky = |mut build: Build, texels| {
        build.scene.sky = Sky::Image {
            image: Arc::new(SkyImage { width, height, texels }),
            rotation: Quat::IDENTITY,
            scale: 1.0,
        };
        build.world()
    };
    let world = with_sky(build, texels.clone());
    let tracer = PathTracer::new(&world);
    let receiver = Receiver { position: Vec3::ZERO, normal: Vec3::Y };
    let light = receiver.gather(&tracer, &paths(4096), 0, no_progress()).unwrap();
    // ∫ cos over a row of width Δφ: Δφ (sin² lower - sin² upper) / 2 of the polar angles.
    let sin_squared = |row: u32| (PI * row as f32 / height as f32).sin().powi(2);
    let projected = TAU / width as f32 * 0.5 * (sin_squared(row + 1) - sin_squared(row));
    let truth = PI * texels[0] + (sun - texels[0]) * projected;
    agrees("sun", light.direct, truth, 1e-4);
    sharp("sun", light.direct, 0.005);
    assert_eq!(light.indirect.mean, Vec3::ZERO);

    // The same sun through a hole: paths that reflect find it too, with an error that shows it.
    let mut build = Build::default();
    for wall in room(Vec3::ZERO, Vec3::splat(2.0)) {
        if wall.positions.iter().all(|p| p.y == 2.0) {
            continue;
        }
        build = build.mesh(wall, diffuse(Vec3::splat(0.6)));
    }
    let world = with_sky(build, texels);
    let tracer = PathTracer::new(&world);
    let receiver = Receiver { position: Vec3::new(1.0, 0.0, 0.2), normal: Vec3::Y };
    let few = receiver.gather(&tracer, &paths(4096), 0, no_progress()).unwrap();
    let many = receiver.gather(&tracer, &paths(65_536), 1, no_progress()).unwrap();
    sharp("sun in a room", few.indirect, 0.03);
    for c in 0..3 {
        let se = few.indirect.se[c].hypot(many.indirect.se[c]);
        let z = (few.indirect.mean[c] - many.indirect.mean[c]) / se;
        assert!(z.abs() < 5.0, "{few:?} {many:?}");
    }
}
