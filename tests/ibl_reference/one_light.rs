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
fn check(name: &str, surface: Surface) {
    let mut stage = Stage::new(&surface);
    for direction in LIGHTS {
        let light = DirectionalLight {
            illuminance: IRRADIANCE.x as f32,
            color: Color::from(LinearRgba::from_vec3((IRRADIANCE / IRRADIANCE.x).as_vec3())),
            ..default()
        };
        let pose = Transform::from_translation(direction).looking_at(Vec3::ZERO, Vec3::Y);
        let light = stage.world().spawn((light, pose)).id();
        let picture = stage.picture();
        let towards = direction.as_dvec3().normalize();
        let pairs: Vec<_> = stage
            .ball
            .pixels(1)
            .into_iter()
            .filter_map(|(i, centre)| {
                let seen = stage.ball.seen_at(centre)?;
                Some((picture[i], shade(&surface, seen.normal, seen.view, towards, IRRADIANCE)))
            })
            .collect();
        let deviation = Deviation::over(&pairs);
        println!("{name}, light from {direction}: {deviation} ({})", stage.headless.adapter());
        assert!(deviation.pixels > 200, "{name}: {deviation}");
        assert!(deviation.absolute < 0.002, "{name}, {direction}: {deviation}");
        stage.world().despawn(light);
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
    check("rough without highlight", rough(0.0));
    check("rough", rough(0.5));
}

#[test]
fn lambert() {
    check("white BTF", Surface::Lambert { albedo: DVec3::ONE });
}

#[test]
fn glossy() {
    for roughness in [0.4, 0.7] {
        for metallic in [0.0, 1.0] {
            check(
                &format!("roughness {roughness}, metallic {metallic}"),
                Surface::standard(roughness, metallic),
            );
        }
    }
}
