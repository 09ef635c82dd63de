//! Pictures refine themselves, rest, and follow changes.

use bevy::prelude::*;
use farlight::{
    ibl::environment_maps::{Environment, Layout},
    prelude::*,
};

use crate::{
    stage::{SIZE, Stage, save},
    support,
};

#[test]
fn a_uniform_environment_lights_a_floor_evenly() {
    let mut stage = Stage::new();
    let floor = (stage.mesh(Plane3d::default().mesh().size(20.0, 20.0)), stage.matte(Color::WHITE));
    stage.spawn(floor);
    let map = Environment::from_equirect(32, 16, vec![Vec3::ONE; 512]).unwrap();
    let settings = ProgressiveLighting { brightness: 0.5, ..default() };
    stage.light(map, settings);
    let camera = stage.camera(Vec3::new(0.0, 3.0, 0.01), Vec3::ZERO);
    stage.refine(camera);
    let middle = stage.floats()[(SIZE * SIZE / 2 + SIZE / 2) as usize];
    println!("a floor in the open: {middle} for 0.5");
    // Burley's diffuse of a rough surface is not quite 1/pi: within a few percent.
    assert!((middle / 0.5 - 1.0).abs().max_element() < 0.06, "{middle}");
}

#[test]
fn a_ball_on_a_floor() {
    let mut stage = Stage::new();
    stage.ball();
    let map = Environment::open(&support::assets().join("environments/sky.hdr"), Layout::Auto);
    stage.light(map.unwrap(), ProgressiveLighting { brightness: 0.5, ..default() });
    let camera = stage.camera(Vec3::new(0.0, 1.5, 3.0), Vec3::new(0.0, 0.3, 0.0));
    for _ in 0..8 {
        stage.update();
    }
    let early = stage.floats();
    save(&early, "early");
    stage.refine(camera);
    let refined = stage.floats();
    save(&refined, "refined");
    let later = stage.floats();
    let apart: Vec<_> = (0..refined.len()).filter(|i| refined[*i] != later[*i]).collect();
    let first = apart.first().map(|i| (i, refined[*i], later[*i]));
    assert!(apart.is_empty(), "a refined picture stays: {} differ, {first:?}", apart.len());
}
