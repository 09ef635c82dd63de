//! What the eyes see, for others: in a window, and as a file.

use bevy::prelude::*;
use farlight::xr::{XrMirror, XrScreenshot, XrScreenshotSaved};

use crate::{
    stage::{SIZE, Stage},
    support::{self, example, linear},
};

/// Something to look at.
fn scene() -> Stage {
    let mut stage = Stage::new();
    stage.sun();
    let mesh = stage.mesh(Cuboid::from_length(0.2));
    for (i, colour) in [Color::WHITE, Color::srgb(0.9, 0.2, 0.1)].into_iter().enumerate() {
        let material = stage.material(StandardMaterial { base_color: colour, ..default() });
        let place = Transform::from_xyz(i as f32 * 0.3 - 0.1, 0.1, -0.9);
        stage.spawn((mesh.clone(), material, place));
    }
    stage
}

#[test]
fn a_file_shows_both_eyes() {
    let mut stage = scene();
    let path = support::scratch("xr_both_eyes.png");
    let _ = std::fs::remove_file(&path);
    (0..3).for_each(|_| stage.update());
    stage.world().write_message(XrScreenshot(path.clone()));
    let mut saved = None;
    for _ in 0..600 {
        stage.update();
        let mut messages = stage.world().resource_mut::<Messages<XrScreenshotSaved>>();
        saved = messages.drain().last();
        if saved.is_some() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let saved = saved.expect("it is said when the file is there");
    assert_eq!(saved, XrScreenshotSaved { path: path.clone(), size: Ok(UVec2::new(2, 1) * SIZE) });
    let file = example::load(&path);
    assert_eq!((file.width, file.height), (2 * SIZE, SIZE));
    // It is what the eyes see, in eight bits of sRGB.
    let eyes = stage.read();
    let mut worst = 0.0_f32;
    for (i, pixel) in file.pixels.iter().enumerate() {
        let (x, y) = (i as u32 % (2 * SIZE), i as u32 / (2 * SIZE));
        let seen = eyes[(x / SIZE) as usize][(y * SIZE + x % SIZE) as usize];
        let file = Color::srgb_u8(pixel[0], pixel[1], pixel[2]).to_linear().to_vec3();
        worst = worst.max((file - seen.clamp(Vec3::ZERO, Vec3::ONE)).abs().max_element());
    }
    // Half a step of 255 is up to 0.009 / 2 in linear light near white; half floats lose 0.0005.
    assert!(worst < 0.006, "{worst}");
    assert!(eyes[0] != eyes[1], "two eyes, two pictures");
}

#[test]
fn without_eyes_there_is_no_file() {
    let mut stage = scene();
    for eye in stage.eyes {
        stage.world().despawn(eye);
    }
    let path = support::scratch("xr_no_eyes.png");
    stage.world().write_message(XrScreenshot(path.clone()));
    stage.update();
    let said: Vec<_> =
        stage.world().resource_mut::<Messages<XrScreenshotSaved>>().drain().collect();
    assert!(said.iter().any(|saved| saved.path == path && saved.size.is_err()), "{said:?}");
}

#[test]
fn a_mirror_shows_the_middle_of_an_eye() {
    let mut stage = scene();
    let size = UVec2::new(SIZE, SIZE / 2);
    let target = linear::target(&mut stage.headless.app, size);
    let place = bevy::camera::RenderTarget::from(target.clone());
    stage.spawn((XrMirror::default(), bevy::camera::Hdr, place));
    (0..3).for_each(|_| stage.update());
    let left = stage.targets[0].clone();
    let pictures = linear::read(&mut stage.headless, &[&left, &target]);
    let [eye, mirror] = &pictures[..] else { unreachable!() };
    assert!(mirror.iter().any(|pixel| pixel.x > 0.1), "it is not black");
    for (i, pixel) in mirror.iter().enumerate() {
        let (x, y) = (i as u32 % SIZE, i as u32 / SIZE);
        let seen = eye[((y + SIZE / 4) * SIZE + x) as usize];
        assert!((pixel - seen).abs().max_element() < 1e-3, "{x} {y}: {pixel} {seen}");
    }
}
