//! A white Lambertian material by formula.

use std::f32::consts::PI;

use farlight::btf::codec::{Info, fade_slope};

use crate::support::flip;
use crate::*;

/// Where light comes from beside the camera, Burley's term is 1.
#[test]
fn white_is_standard_materials_diffuse() {
    let mut stage = Stage::new();
    stage.camera(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 0.0);
    stage.spawn((
        PointLight { intensity: 4.0 * PI * 30.0, range: 50.0, ..default() },
        Transform::from_xyz(0.01, 0.0, 4.0),
    ));
    let ball = stage.mesh(Sphere::new(1.2).mesh().uv(48, 32));
    let material = stage.standard();
    let object = stage.spawn((Mesh3d(ball), material));
    let standard = stage.picture();
    let material = stage.white();
    stage.world().entity_mut(object).remove::<MeshMaterial3d<StandardMaterial>>().insert(material);
    stage.settle();
    let measured = stage.picture();
    stage.save(&standard, "white-standard");
    stage.save(&measured, "white-measured");
    assert!(standard.mean() > 20.0);
    let difference = flip::between(&standard, &measured);
    println!(
        "white ball: FLIP mean {:.4}, 99th percentile {:.4} ({})",
        difference.mean(),
        difference.percentile(0.99),
        stage.headless.adapter()
    );
    assert!(difference.mean() < 0.02 && difference.percentile(0.99) < 0.1);
}

/// Radiance is E cos / pi for every light and view: to 0.5 %, of which the material's tables and
/// half floats take 0.15 %.
#[test]
fn white_is_lambert_by_formula() {
    let mut stage = Stage::new();
    let camera = stage.float_camera(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO, 2.0);
    let plane = stage.mesh(Plane3d::default().mesh().size(4.0, 4.0));
    let material = stage.white();
    stage.spawn((Mesh3d(plane), material));
    stage.settle();
    let mut worst = 0.0_f32;
    for from in [Vec3::new(0.0, 3.0, 0.0), Vec3::new(2.0, 2.0, 1.0), Vec3::new(-3.0, 0.8, 2.0)] {
        let up = if from.x == 0.0 { Vec3::NEG_Z } else { Vec3::Y };
        let pose = Transform::from_translation(from).looking_at(Vec3::ZERO, up);
        stage.world().entity_mut(camera).insert(pose);
        for theta in [0.0_f32, 30.0, 60.0, 80.0] {
            for phi in [20.0_f32, 200.0] {
                let (theta, phi) = (theta.to_radians(), phi.to_radians());
                let to_light =
                    Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
                for kind in 0..3 {
                    worst = worst.max(deviation(&mut stage, to_light, kind));
                }
            }
        }
    }
    println!("Lambert by formula: within {:.3} %", 100.0 * worst);
    assert!(worst < 0.005, "{worst}");
}

/// Largest relative deviation in the middle of the picture under one light.
fn deviation(stage: &mut Stage, to_light: Vec3, kind: u32) -> f32 {
    const DISTANCE: f32 = 5.0;
    let pose = Transform::from_translation(DISTANCE * to_light)
        .looking_at(Vec3::ZERO, if to_light.y > 0.99 { Vec3::X } else { Vec3::Y });
    // Candela for point and spot lights, lux for the directional one; both about 3 lux.
    let candela = 75.0;
    let range = 1e4;
    let light = match kind {
        0 => stage.spawn((PointLight { intensity: 4.0 * PI * candela, range, ..default() }, pose)),
        1 => stage.spawn((
            SpotLight {
                intensity: 4.0 * PI * candela,
                range,
                inner_angle: 0.7,
                outer_angle: 0.9,
                ..default()
            },
            pose,
        )),
        _ => stage.spawn((DirectionalLight { illuminance: 3.0, ..default() }, pose)),
    };
    let pixels = stage.floats();
    stage.world().entity_mut(light).despawn();
    let expected = if kind == 2 { 3.0 } else { candela / (DISTANCE * DISTANCE) };
    let expected = expected * to_light.y / PI;
    // The pixel's centre is a sixty-fourth of two metres off the axis.
    let middle = [31, 32].map(|x| [31, 32].map(|y| at(&pixels, x, y)));
    let mean: Vec3 = middle.as_flattened().iter().sum::<Vec3>() / 4.0;
    let deviation = (mean / expected - 1.0).abs().max_element();
    assert!(deviation < 0.005, "{to_light}, light {kind}: {mean} instead of {expected}");
    deviation
}

/// Twice the same plane: light lower than was measured falls with its cosine, or does not. The
/// half floats and the tables take 0.5 %.
#[test]
fn light_fades_beyond_what_was_measured() {
    let mut stage = Stage::new();
    stage.float_camera(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 2.0);
    let info = Info { light_limit: Some(60.0), ..white().info().clone() };
    let slope = fade_slope(info.light_limit);
    let btf = stage.btf(white().with_info(info));
    let square = stage.mesh(Rectangle::new(1.0, 2.0));
    for (fade_beyond_measured, x) in [(true, -0.5), (false, 0.5)] {
        let material =
            stage.material(BtfMaterial { fade_beyond_measured, ..BtfMaterial::new(btf.clone()) });
        stage.spawn((Mesh3d(square.clone()), material, Transform::from_xyz(x, 0.0, 0.0)));
    }
    for degrees in [30.0_f32, 58.0, 70.0, 80.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let light = stage.spawn((
            DirectionalLight { illuminance: 4.0 * PI, ..default() },
            Transform::from_xyz(0.0, sine, cosine).looking_at(Vec3::ZERO, Vec3::X),
        ));
        stage.settle();
        let pixels = stage.floats();
        let [faded, plain] = [1, 3].map(|part| at(&pixels, part * SIZE / 4, SIZE / 2).y);
        assert!((plain / (4.0 * cosine) - 1.0).abs() < 0.01, "{degrees}: {plain}");
        let share = (slope * cosine).min(1.0);
        assert!((faded / plain - share).abs() < 0.005, "{degrees}: {faded} of {plain}");
        stage.world().despawn(light);
    }
}
