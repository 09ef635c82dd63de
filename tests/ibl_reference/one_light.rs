//! The CPU's shading is Bevy's: one directional light.

use crate::{support::shading::shade, *};

/// From beside the camera, from the side, from behind, from below.
const LIGHTS: [Vec3; 4] = [
    Vec3::new(0.5, 0.6, 1.0),
    Vec3::new(1.0, 0.3, 0.1),
    Vec3::new(-0.8, 0.5, -0.4),
    Vec3::new(0.1, -1.0, 0.3),
];

/// In lux; different in each channel.
const IRRADIANCE: DVec3 = DVec3::new(4.0, 2.0, 1.0);

/// A ball under each light in turn, every pixel of it against the formula at its centre: half floats
/// that are cut off, not rounded, are 0.05 % too dark, and facets take a little more.
fn check(surfaces: &[Surface]) {
    let mut stage = Stage::new(surfaces, 256);
    for direction in LIGHTS {
        let light = DirectionalLight {
            illuminance: IRRADIANCE.x as f32,
            color: Color::from(LinearRgba::from_vec3((IRRADIANCE / IRRADIANCE.x).as_vec3())),
            ..default()
        };
        let pose = Transform::from_translation(direction).looking_at(Vec3::ZERO, Vec3::Y);
        let light = stage.world().spawn((light, pose)).id();
        let pictures = stage.pictures();
        stage.world().despawn(light);
        let towards = direction.as_dvec3().normalize();
        for (surface, picture) in surfaces.iter().zip(pictures) {
            let pixels = stage.ball.pixels(1).into_iter();
            let pairs: Vec<_> = pixels
                .filter_map(|(i, centre)| {
                    let seen = stage.ball.seen_at(centre)?;
                    Some((picture[i], shade(surface, seen.normal, seen.view, towards, IRRADIANCE)))
                })
                .collect();
            let deviation = Deviation::over(&pairs);
            println!("{surface}, light from {direction}: {deviation}");
            assert!(deviation.pixels > 200, "{surface}: {deviation}");
            assert!(
                deviation.absolute < 0.002,
                "{surface}, {direction}: {deviation} ({})",
                stage.headless.adapter()
            );
        }
    }
}

#[test]
fn diffuse() {
    let base_color = DVec3::new(0.9, 0.6, 0.3);
    let rough = |reflectance| Surface::Standard {
        base_color,
        metallic: 0.0,
        perceptual_roughness: 1.0,
        reflectance,
    };
    check(&[rough(0.0), rough(0.5), Surface::Lambert { albedo: DVec3::ONE }]);
}

#[test]
fn glossy() {
    let surfaces = [0.4, 0.7].map(|r| [0.0, 1.0].map(|metallic| Surface::standard(r, metallic)));
    check(surfaces.as_flattened());
}
