//! Open scenes whose irradiance is a form factor times a radiosity.

use std::f32::consts::PI;

use farlight_gi_solver::{
    estimate::{Estimate, no_progress},
    path::PathTracer,
    receiver::Receiver,
};
use glam::Vec3;

use crate::{
    build::{Build, diffuse, directional, disc, emitter, point, quad, sphere},
    check::{agrees, paths, sharp},
};

/// What an upward receiver at the origin sees.
fn at_origin(build: &Build) -> farlight_gi_solver::receiver::ReceiverLight {
    let receiver = Receiver { position: Vec3::ZERO, normal: Vec3::Y };
    receiver.gather(&PathTracer::new(&build.world()), &paths(8192), 0, no_progress()).unwrap()
}

/// A glowing disc of radius R at height h over the receiver: E = π L R² / (R² + h²).
#[test]
fn glowing_disc() {
    let emitted = Vec3::new(3.0, 1.0, 0.5);
    for (radius, height) in [(1.0_f32, 1.0_f32), (0.5, 2.0), (4.0, 0.5)] {
        let build = Build::default()
            .mesh(disc(Vec3::Y * height, Vec3::Y, radius), emitter(Vec3::ZERO, emitted));
        let light = at_origin(&build);
        let factor = radius * radius / (radius * radius + height * height);
        agrees("disc", light.indirect, PI * emitted * factor, 1e-4);
        sharp("disc", light.indirect, 0.01);
        // Light that no surface has reflected yet is part of both.
        assert_eq!(light.indirect, light.one_bounce);
    }
}

/// A disc lit by parallel light with irradiance E0 reflects ρ E0: E = ρ E0 R² / (R² + h²), and there
/// is nothing for a second reflection.
#[test]
fn lit_disc() {
    let (rho, sun) = (Vec3::new(0.9, 0.5, 0.1), Vec3::new(4.0, 5.0, 6.0));
    let build = Build::default()
        .mesh(disc(Vec3::Y, Vec3::Y, 1.0), diffuse(rho))
        .light(directional(Vec3::Y, sun));
    // The receiver looks up at the disc; the light travels upwards and hits the disc from below.
    let light = at_origin(&build);
    agrees("lit disc", light.indirect, rho * sun * 0.5, 1e-4);
    assert_eq!(light.indirect, light.one_bounce);
    assert_eq!(light.direct, Estimate::default(), "the light comes from behind the receiver");
}

/// A glowing sphere of radius r at distance d: E = π L (r/d)² for a receiver that faces it.
#[test]
fn glowing_sphere() {
    let emitted = Vec3::new(1.0, 2.0, 3.0);
    let build =
        Build::default().mesh(sphere(Vec3::Y * 3.0, 1.0), emitter(Vec3::splat(0.7), emitted));
    let light = at_origin(&build);
    agrees("sphere", light.indirect, PI * emitted / 9.0, 1e-3);
    sharp("sphere", light.indirect, 0.02);
}

/// A sphere under a constant sky hides 1/9 of it and reflects ρ as much: it is convex, so each of
/// its points receives a full hemisphere.
#[test]
fn sphere_under_the_sky() {
    let (rho, sky) = (Vec3::new(0.3, 0.5, 0.8), Vec3::new(2.0, 1.0, 0.5));
    let build = Build::default().mesh(sphere(Vec3::Y * 3.0, 1.0), diffuse(rho)).sky(sky);
    let light = at_origin(&build);
    agrees("sky beside the sphere", light.direct, PI * sky * (8.0 / 9.0), 2e-4);
    agrees("sky by way of the sphere", light.indirect, PI * sky * rho / 9.0, 1e-3);
    sharp("sky by way of the sphere", light.indirect, 0.02);
}

/// A plane under a point light: I cos θ / r² at every distance, nothing indirect, and the shadow of
/// a small plate where geometry says.
#[test]
fn lit_plane() {
    let (height, intensity) = (2.0, Vec3::new(30.0, 20.0, 10.0));
    let floor = quad(Vec3::new(-50.0, 0.0, -50.0), Vec3::Z * 100.0, Vec3::X * 100.0);
    let plate = quad(Vec3::new(0.9, 1.0, -0.1), Vec3::X * 0.2, Vec3::Z * 0.2);
    let world = Build::default()
        .mesh(floor, diffuse(Vec3::splat(0.5)))
        .mesh(plate, diffuse(Vec3::ZERO))
        .light(point(Vec3::Y * height, intensity))
        .world();
    for x in [0.0_f32, 0.5, 1.7, 2.3, 10.0, 40.0] {
        let receiver = Receiver { position: Vec3::X * x, normal: Vec3::Y };
        let light =
            receiver.gather(&PathTracer::new(&world), &paths(256), 0, no_progress()).unwrap();
        let squared = x * x + height * height;
        let expected = intensity * height / (squared * squared.sqrt());
        assert!(
            light.direct.mean.distance(expected) <= 1e-5 * expected.length(),
            "x = {x}: {} instead of {expected}",
            light.direct.mean
        );
        assert_eq!(light.direct.se, Vec3::ZERO);
        // The plate is black and a plane does not see itself.
        assert_eq!(light.indirect, Estimate::default(), "x = {x}");
    }
    // The plate spans x 0.9..1.1 at half the light's height: its shadow is 1.8..2.2.
    for x in [1.81_f32, 2.0, 2.19] {
        let receiver = Receiver { position: Vec3::X * x, normal: Vec3::Y };
        assert_eq!(receiver.direct(&world), Vec3::ZERO, "x = {x}");
    }
    for x in [1.79_f32, 2.21] {
        let receiver = Receiver { position: Vec3::X * x, normal: Vec3::Y };
        assert!(receiver.direct(&world).x > 0.0, "x = {x}");
    }
}

/// The lower side of a plane gets nothing from a light above it, at any scale of coordinates: no
/// light leaks through the surface that rays start from.
#[test]
fn no_leaks_at_any_scale() {
    for scale in [0.01_f32, 1.0, 100.0, 10_000.0] {
        let tilt = Vec3::new(1.0, 0.3, 0.2).normalize();
        let other = tilt.any_orthonormal_vector() * scale * 4.0;
        let tilt = tilt * scale * 4.0;
        let corner = Vec3::new(3.0, 1.0, -2.0) * scale;
        let world = Build::default()
            .mesh(quad(corner, tilt, other), diffuse(Vec3::ONE))
            .sky(Vec3::ONE)
            .world();
        let normal = tilt.cross(other).normalize();
        for (a, b) in [(0.5, 0.5), (0.1, 0.9), (0.77, 0.33)] {
            let position = corner + tilt * a + other * b;
            for normal in [normal, -normal] {
                let receiver = Receiver { position, normal };
                let light = receiver
                    .gather(&PathTracer::new(&world), &paths(512), 0, no_progress())
                    .unwrap();
                assert_eq!(light.indirect.mean, Vec3::ZERO, "scale {scale}");
                assert!((light.direct.mean.x / PI - 1.0).abs() < 1e-5, "scale {scale}");
            }
        }
    }
}
