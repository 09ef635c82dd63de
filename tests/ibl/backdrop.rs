//! The environment is seen where its light comes from.

use bevy::{light::Skybox, prelude::*};
use farlight::{ibl::EnvironmentDots, ibl::environment_maps::Environment, prelude::*};

use crate::stage::{SIZE, Stage, save};

/// Dark, but for a red patch to the right and a green one ahead, both above the horizon.
fn map() -> Environment {
    let texels = (0..64 * 32)
        .map(|i| match (i % 64, i / 64) {
            (44..52, 8..14) => Vec3::new(8.0, 0.0, 0.0),
            (30..34, 10..14) => Vec3::new(0.0, 3.0, 0.0),
            _ => Vec3::splat(0.05),
        })
        .collect();
    Environment::from_equirect(64, 32, texels).unwrap()
}

fn middle(pixels: &[Vec3]) -> Vec3 {
    pixels[(SIZE * SIZE / 2 + SIZE / 2) as usize]
}

#[test]
fn the_sky_is_seen_where_the_map_has_it_and_turns_with_it() {
    let mut stage = Stage::new();
    stage.light(map(), ProgressiveLighting { brightness: 0.5, lights: 8, ..default() });
    // The middle of the red patch: azimuth 90 degrees, 61.875 degrees from the zenith.
    let polar = 61.875_f32.to_radians();
    let right = Vec3::new(polar.sin(), polar.cos(), 0.0);
    let camera = stage.camera(Vec3::ZERO, right);
    stage.world().entity_mut(camera).insert(EnvironmentBackdrop::default());
    let there = move |world: &mut World| world.get::<Skybox>(camera).is_some();
    stage.until("a skybox", there);
    stage.refine(camera);
    let seen = middle(&stage.floats());
    println!("red patch: {seen}");
    assert!((seen - Vec3::new(4.0, 0.0, 0.0)).abs().max_element() < 0.02, "{seen}");

    // Turned by a quarter to the left, what was on the right is ahead; dimmed, it is darker.
    stage.world().resource_mut::<ProgressiveLighting>().rotation =
        Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    stage.world().entity_mut(camera).insert((
        EnvironmentBackdrop { brightness: 0.5 },
        Transform::default().looking_to(Vec3::new(0.0, right.y, -right.x), Vec3::Y),
    ));
    stage.update();
    stage.refine(camera);
    let seen = middle(&stage.floats());
    println!("turned and dimmed: {seen}");
    assert!((seen - Vec3::new(2.0, 0.0, 0.0)).abs().max_element() < 0.02, "{seen}");

    stage.world().entity_mut(camera).remove::<EnvironmentBackdrop>();
    stage.update();
    assert!(stage.world().get::<Skybox>(camera).is_none());
}

#[test]
fn image_based_light_is_the_same_light_and_shines_only_where_the_lights_do_not() {
    let mut stage = Stage::new();
    let floor = (stage.mesh(Plane3d::default().mesh().size(20.0, 20.0)), stage.matte(Color::WHITE));
    stage.spawn(floor);
    stage.light(map(), ProgressiveLighting { brightness: 0.5, ..default() });
    let camera = stage.camera(Vec3::new(0.0, 3.0, 0.01), Vec3::ZERO);
    stage.world().entity_mut(camera).insert(ImageBasedFallback);
    stage.refine(camera);
    assert!(stage.world().get::<EnvironmentMapLight>(camera).is_none(), "counted twice");
    let lights = middle(&stage.floats());
    stage.world().resource_mut::<ProgressiveLighting>().enabled = false;
    let there = move |world: &mut World| world.get::<EnvironmentMapLight>(camera).is_some();
    stage.until("image-based light", there);
    stage.refine(camera);
    let image_based = middle(&stage.floats());
    println!("a floor: {lights} by lights, {image_based} by images");
    // Burley's diffuse for each light, Lambert's for the images.
    let apart = (lights / image_based - 1.0).abs();
    assert!(apart.x < 0.1 && apart.y < 0.1, "{lights} {image_based}");
    stage.world().resource_mut::<ProgressiveLighting>().enabled = true;
    for _ in 0..3 {
        stage.update();
    }
    assert!(stage.world().get::<EnvironmentMapLight>(camera).is_none(), "counted twice");
}

#[test]
fn dots_lie_on_the_sky_alone_and_disturb_nothing() {
    let mut stage = Stage::new();
    stage.ball();
    let settings = ProgressiveLighting { brightness: 0.5, lights: 32, per_frame: 4, ..default() };
    stage.light(map(), settings);
    let camera = stage.camera(Vec3::new(0.0, 0.5, 3.0), Vec3::new(0.0, 0.9, 0.0));
    // Their pipeline is made once, and a new pipeline begins the picture anew.
    stage.world().entity_mut(camera).insert(EnvironmentDots { radius: 2.0 });
    stage.refine(camera);
    stage.world().entity_mut(camera).remove::<EnvironmentDots>();
    for _ in 0..4 {
        stage.update();
    }
    stage.refine(camera);
    let without = stage.floats();
    stage.world().entity_mut(camera).insert(EnvironmentDots { radius: 2.0 });
    stage.update();
    let with = stage.floats();
    save(&with, "dots");
    let refined = stage.world().get::<Refinement>(camera).is_some_and(Refinement::is_refined);
    assert!(refined, "dots disturb");
    let width = SIZE as usize;
    let dark = |i: usize| without.get(i).is_none_or(|pixel| *pixel == Vec3::ZERO);
    let changed = |i: &usize| with[*i] != without[*i];
    // Edges are of both.
    let inside = |i: &usize| {
        let around = [*i, i + 1, i.wrapping_sub(1), i + width, i.wrapping_sub(width)];
        around.into_iter().all(|i| !dark(i))
    };
    let on_objects = (0..with.len()).filter(inside).filter(changed).count();
    let dots = (0..with.len()).filter(|i| dark(*i)).filter(changed).count();
    println!("{dots} pixels of dots on the sky, {on_objects} elsewhere");
    assert!(dots > 10, "no dots");
    assert_eq!(on_objects, 0);
    stage.world().entity_mut(camera).remove::<EnvironmentDots>();
    stage.update();
    assert_eq!(stage.floats(), without);
}

#[test]
fn a_camera_that_no_longer_refines_is_an_ordinary_one() {
    let mut stage = Stage::new();
    stage.light(map(), ProgressiveLighting { brightness: 0.5, lights: 8, ..default() });
    let camera = stage.camera(Vec3::ZERO, Vec3::NEG_Z);
    stage.refine(camera);
    stage.world().entity_mut(camera).remove::<ProgressiveCamera>();
    stage.update();
    // A kept picture would still be black.
    stage.world().insert_resource(ClearColor(Color::linear_rgb(0.5, 0.25, 0.125)));
    assert_eq!(middle(&stage.floats()), Vec3::new(0.5, 0.25, 0.125));
}
