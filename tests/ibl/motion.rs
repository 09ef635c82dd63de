//! Pictures that are never still: error, brightness and trails.

use std::sync::{Arc, Mutex};

use bevy::{
    prelude::*,
    render::gpu_readback::{Readback, ReadbackComplete},
};
use farlight::{
    ibl::environment_maps::{Environment, Layout},
    prelude::*,
};

use crate::{
    stage::{Stage, save},
    support,
};

const EYE: Vec3 = Vec3::new(0.0, 1.2, 2.4);
const TARGET: Vec3 = Vec3::new(0.0, 0.3, 0.0);
/// Frames of a second.
const SECOND: u32 = 60;

fn sky() -> Environment {
    Environment::open(&support::assets().join("environments/sky.hdr"), Layout::Auto).unwrap()
}

/// A ball on a floor under a sky, looked at by a camera.
fn scene(settings: ProgressiveLighting) -> (Stage, Entity) {
    let mut stage = Stage::new();
    stage.ball();
    stage.light(sky(), ProgressiveLighting { brightness: 0.5, ..settings });
    let camera = stage.camera(EYE, TARGET);
    // Until there is light and every pipeline is made.
    for _ in 0..12 {
        stage.update();
    }
    (stage, camera)
}

/// A head that never rests, more than people sway who stand: two centimetres to the sides and 0.7
/// degrees once a second, less up and down twice a second; back at its place after each second.
fn sway(frame: u32) -> Transform {
    let beat = |per_second: u32| {
        let turn = (frame * per_second % SECOND) as f32 / SECOND as f32;
        (turn * std::f32::consts::TAU).sin()
    };
    let eye = EYE + 0.02 * Vec3::new(beat(1), 0.4 * beat(2), 0.5 * beat(1));
    let place = Transform::from_translation(eye).looking_at(TARGET, Vec3::Y);
    place.with_rotation(place.rotation * Quat::from_rotation_y(0.7_f32.to_radians() * beat(1)))
}

/// What the camera showed in its last frame.
fn last(stage: &mut Stage, camera: Entity) -> Vec<Vec3> {
    stage.world().get_mut::<Camera>(camera).unwrap().is_active = false;
    let pixels = stage.floats();
    stage.world().get_mut::<Camera>(camera).unwrap().is_active = true;
    pixels
}

/// Mean difference over the mean.
fn error(pixels: &[Vec3], right: &[Vec3]) -> f32 {
    let sum = |values: &mut dyn Iterator<Item = Vec3>| values.map(|v| v.element_sum()).sum::<f32>();
    let apart = sum(&mut pixels.iter().zip(right).map(|(a, b)| (a - b).abs()));
    apart / sum(&mut right.iter().copied())
}

#[test]
fn a_swaying_head_sees_a_refined_picture() {
    let (mut stage, camera) =
        scene(ProgressiveLighting { lights: 1024, per_frame: 8, ..default() });
    stage.refine(camera);
    let right = stage.floats();
    save(&right, "sway_right");

    let (mut stage, camera) = scene(default());
    stage.world().get_mut::<Transform>(camera).unwrap().translation.x += 0.01;
    stage.update();
    *stage.world().get_mut::<Transform>(camera).unwrap() = sway(0);
    for _ in 0..SECOND {
        stage.update();
    }
    let still = last(&mut stage, camera);

    let (mut stage, camera) = scene(default());
    for frame in 1..=SECOND {
        *stage.world().get_mut::<Transform>(camera).unwrap() = sway(frame);
        stage.update();
    }
    let swaying = last(&mut stage, camera);
    save(&still, "sway_still");
    save(&swaying, "sway_swaying");
    let (still, swaying) = (error(&still, &right), error(&swaying, &right));
    println!(
        "after a second: still {still:.4}, swaying {swaying:.4}, {:.2} times",
        swaying / still
    );
    assert!(swaying <= 2.0 * still, "{swaying} against {still}");
}

#[test]
fn brightness_never_jumps() {
    let (mut stage, camera) = scene(default());
    stage.refine(camera);
    let refined: f32 = stage.floats().iter().map(|v| v.element_sum()).sum();
    let means = Arc::new(Mutex::new(Vec::<f32>::new()));
    let all = means.clone();
    let readback = Readback::texture(stage.floats.clone());
    stage.world().spawn(readback).observe(move |event: On<ReadbackComplete>| {
        let sum = support::linear::texels(&event.data).iter().map(|v| v.element_sum()).sum();
        all.lock().unwrap().push(sum);
    });
    // It rests, the head moves for a while, and rests again.
    for frame in 0..100 {
        let at = if (10..40).contains(&frame) { frame - 9 } else { 0 };
        stage.world().get_mut::<Transform>(camera).unwrap().set_if_neq(sway(at));
        stage.update();
    }
    let means: Vec<f32> = means.lock().unwrap().iter().map(|sum| sum / refined).collect();
    let steps = means.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
    let (low, high) = means.iter().fold((9.0_f32, 0.0_f32), |(l, h), m| (l.min(*m), h.max(*m)));
    println!("{} frames: brightness {low:.4} to {high:.4}, largest step {steps:.4}", means.len());
    assert!(means.len() > 80, "the camera was read");
    // Other places of the head see another part of the scene.
    assert!(low > 0.97 && high < 1.03 && steps < 0.015, "{means:?}");
}

#[test]
fn what_moves_leaves_no_trail() {
    let (mut stage, camera) = scene(default());
    let ball = stage
        .world()
        .query_filtered::<Entity, (With<Mesh3d>, With<Transform>)>()
        .iter(stage.headless.app.world())
        .find(|entity| {
            stage.headless.app.world().get::<Transform>(*entity).unwrap().translation.y > 0.1
        })
        .unwrap();
    stage.refine(camera);
    for frame in 1..=20 {
        let at = Vec3::new(0.05 * frame as f32, 0.5, 0.0);
        stage.world().get_mut::<Transform>(ball).unwrap().translation = at;
        stage.update();
    }
    let moving = last(&mut stage, camera);
    stage.refine(camera);
    let right = stage.floats();
    save(&moving, "trail_moving");
    save(&right, "trail_right");
    let apart = error(&moving, &right);
    println!("while the ball moves: {apart:.4}");
    assert!(apart < 0.08, "{apart}");
}
