//! Direct light against brute force.

use farlight_gi_solver::{
    World,
    bake::{Density, DirectLight, Layout, LayoutSettings, direct},
    estimate::no_progress,
    sampling::{Frame, concentric_disk, sobol_owen_4d},
    scene::{Light, LightKind},
    visibility::offset_origin,
};
use glam::{Vec2, Vec3};

use crate::{common::Builder, scenes::built};

/// A floor of 4 m with a table above it, and a wall; the floor is the first receiver.
fn scene() -> Builder {
    let mut b = Builder::default();
    b.quad(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0, Vec3::ONE);
    b.quad(Vec3::new(1.0, 1.0, 1.3), Vec3::X * 1.5, Vec3::Z * 1.1, Vec3::ONE);
    b.quad(Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 2.0, Vec3::ONE);
    b
}

fn light(kind: LightKind) -> Light {
    Light {
        kind,
        position: Vec3::new(2.3, 2.7, 2.2),
        direction: Vec3::new(0.1, -1.0, 0.2).normalize(),
        intensity: Vec3::new(30.0, 20.0, 10.0),
        range: 6.0,
    }
}

/// The mean over a square texel of the floor and over the light.
fn brute(world: &World, corner: Vec3, edge: f32, light: &DirectLight) -> Vec3 {
    let n = 4096;
    let mut sum = Vec3::ZERO;
    for i in 0..n {
        let u = sobol_owen_4d(i, 99);
        let point = corner + Vec3::new(u[0], 0.0, u[1]) * edge;
        let Some(sample) = light.light.sample(point) else { continue };
        let cos = sample.to_light.dot(Vec3::Y);
        let disk = concentric_disk(Vec2::new(u[2], u[3])) * light.radius;
        let frame = Frame::new(sample.to_light);
        let across = frame.tangent * disk.x + frame.bitangent * disk.y;
        let moved = Light {
            position: light.light.position + across,
            direction: -(sample.to_light + across),
            ..light.light
        };
        if cos > 0.0 && world.sees_light(offset_origin(point, Vec3::Y), &moved) {
            sum += sample.irradiance * cos;
        }
    }
    sum / n as f32
}

#[test]
fn shadows_are_those_of_brute_force() {
    let (scene, receivers) = built(scene());
    let world = World::new(&scene);
    let settings =
        LayoutSettings { page_size: 64, max_pages: 1, density: Density::TexelsPerMetre(8.0) };
    let layout = Layout::new(&scene, &world, receivers.clone(), &settings);
    let spot = LightKind::Spot { inner_angle: 0.3, outer_angle: 0.7 };
    for (what, kind, radius) in [
        ("sharp point", LightKind::Point, 0.0),
        ("soft point", LightKind::Point, 0.3),
        ("spot", spot, 0.1),
        ("sun", LightKind::Directional, 0.0),
        ("soft sun", LightKind::Directional, 0.1),
    ] {
        let light = DirectLight { light: light(kind), radius };
        let found = direct(&world, &layout, &[light], no_progress()).unwrap();
        let twice = direct(&world, &layout, &[light, light], no_progress()).unwrap();
        let rect = layout.placements[0].rect;
        let edge = 4.0 / rect.width as f32;
        let (mut worst, mut sum, mut squares, mut n, mut partly) = (0.0_f32, 0.0, 0.0, 0, 0);
        let brightest = found.iter().map(|e| e.x).fold(0.0, f32::max);
        for (i, texel) in layout.texels().enumerate() {
            if texel.instance != receivers[0] || (texel.x + texel.y * 7) % 5 != 0 {
                continue;
            }
            // The floor's u runs along z, its v along x.
            let corner =
                Vec3::new((texel.y - rect.y) as f32, 0.0, (texel.x - rect.x) as f32) * edge;
            let truth = brute(&world, corner, edge, &light);
            let error = (found[i] - truth).x / brightest;
            worst = worst.max(error.abs());
            sum += error;
            squares += error * error;
            n += 1;
            partly += i32::from(truth.x > 0.0 && truth.x < brightest * 0.4);
            assert!((twice[i] - found[i] * 2.0).abs().max_element() < 1e-4 * brightest);
        }
        let (mean, rms) = (sum / n as f32, (squares / n as f32).sqrt());
        println!("{what}: worst {worst:.4}, mean {mean:+.5}, rms {rms:.5} of {n} ({partly} dark)");
        assert!(n > 100 && worst < 0.06 && rms < 0.012 && mean.abs() < 2e-3, "{what}");
    }
}
