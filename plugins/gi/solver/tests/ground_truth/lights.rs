//! Visibility and the shapes of lights.

use farlight_gi_solver::{
    receiver::Receiver,
    scene::{Light, LightKind},
};
use glam::Vec3;

use crate::build::{Build, black, diffuse, directional, point, quad};

/// A spot has full intensity inside, falls as `KHR_lights_punctual` says, and ends at its cone.
#[test]
fn spot() {
    let spot = Light {
        kind: LightKind::Spot { inner_angle: 0.2, outer_angle: 0.6 },
        ..point(Vec3::Y, Vec3::splat(2.0))
    };
    let world = Build::default()
        .mesh(quad(Vec3::new(-9.0, 0.0, -9.0), Vec3::Z * 18.0, Vec3::X * 18.0), black())
        .light(spot)
        .world();
    for angle in [0.0_f32, 0.15, 0.3, 0.5, 0.59, 0.65, 1.0] {
        let receiver = Receiver { position: Vec3::X * angle.tan(), normal: Vec3::Y };
        let ramp =
            ((angle.cos() - 0.6_f32.cos()) / (0.2_f32.cos() - 0.6_f32.cos())).clamp(0.0, 1.0);
        let expected = 2.0 * ramp * ramp * angle.cos().powi(3);
        let found = receiver.direct(&world).x;
        assert!((found - expected).abs() < 1e-5, "{angle}: {found} instead of {expected}");
    }
}

/// A light sees its surroundings even if it is placed exactly on a surface.
#[test]
fn a_light_on_the_ceiling_is_not_hidden_by_it() {
    let floor = quad(Vec3::new(-3.0, 0.0, -3.0), Vec3::Z * 6.0, Vec3::X * 6.0);
    let ceiling = quad(Vec3::new(-3.0, 2.5, -3.0), Vec3::X * 6.0, Vec3::Z * 6.0);
    let world = Build::default()
        .mesh(floor, diffuse(Vec3::ONE))
        .mesh(ceiling, diffuse(Vec3::ONE))
        .light(point(Vec3::new(0.1, 2.5, 0.2), Vec3::ONE))
        .world();
    for i in 0..100 {
        let x = i as f32 * 0.05 - 2.5;
        let receiver = Receiver { position: Vec3::new(x, 0.0, 0.7 * x), normal: Vec3::Y };
        assert!(receiver.direct(&world).x > 0.0, "{x}");
    }
}

/// Visibility is about what stands between, not about cones or the side that faces the light.
#[test]
fn visibility() {
    let plate = quad(Vec3::new(-1.0, 1.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    let world = Build::default()
        .mesh(plate, black())
        .light(point(Vec3::Y * 2.0, Vec3::ONE))
        .light(directional(-Vec3::Y, Vec3::ONE))
        .world();
    let [lamp, sun] = [world.lights[0], world.lights[1]];
    for (place, lamp_seen, sun_seen) in [
        (Vec3::ZERO, false, false),
        (Vec3::X * 1.5, false, true),
        (Vec3::X * 2.5, true, true),
        (Vec3::new(0.0, 1.5, 0.0), true, true),
        (Vec3::new(0.0, 3.0, 0.0), true, true),
    ] {
        assert_eq!(world.sees_light(place, &lamp), lamp_seen, "{place}");
        assert_eq!(world.sees_light(place, &sun), sun_seen, "{place}");
    }
}
