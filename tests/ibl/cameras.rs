//! Several cameras: those that refine, each for itself, and those that don't.

use bevy::{
    camera::{RenderTarget, Viewport, visibility::RenderLayers},
    prelude::*,
};
use farlight::{ibl::environment_maps::Environment, prelude::*};

use crate::stage::{SIZE, Stage, save};

const EYES: [Vec3; 2] = [Vec3::new(-0.4, 1.5, 3.0), Vec3::new(0.4, 2.0, 2.5)];
const TO: Vec3 = Vec3::new(0.0, 0.3, 0.0);

fn sky() -> Environment {
    let pixel = |i: usize| {
        let (x, y) = (i % 32, i / 32);
        Vec3::new(0.3, 0.4, 0.6) * (16 - y) as f32 / 16.0
            + if (x, y) == (20, 3) { Vec3::splat(60.0) } else { Vec3::ZERO }
    };
    Environment::from_equirect(32, 16, (0..512).map(pixel).collect()).unwrap()
}

fn stage() -> Stage {
    let mut stage = Stage::new();
    stage.ball();
    stage.light(sky(), ProgressiveLighting { lights: 40, brightness: 0.5, ..default() });
    stage
}

#[test]
fn a_camera_that_does_not_refine_sees_nothing_of_it() {
    let mut stage = stage();
    stage.world().resource_mut::<ProgressiveLighting>().enabled = false;
    let lamp = DirectionalLight { illuminance: 1.0, shadow_maps_enabled: true, ..default() };
    let down = Transform::default().looking_to(Vec3::new(0.4, -1.0, -0.3), Vec3::Y);
    stage.spawn((lamp, down));
    // Something that only the layer of the second refining camera shows.
    let box_ = (stage.mesh(Cuboid::from_length(0.5)), stage.matte(Color::WHITE));
    let on = RenderLayers::layer(1);
    stage.spawn((box_, Transform::from_xyz(0.9, 0.25, 0.8), on));
    let map = stage.target(UVec2::splat(SIZE));
    let plain = stage.plain_camera(&map, EYES[0], TO);
    stage.camera(EYES[1], TO);
    let other = stage.target(UVec2::splat(SIZE));
    let second = stage.plain_camera(&other, EYES[1], TO);
    stage
        .world()
        .entity_mut(second)
        .insert((ProgressiveCamera::default(), RenderLayers::from_layers(&[0, 1])));
    for layers in [RenderLayers::default(), RenderLayers::from_layers(&[0, 1, 7])] {
        stage.world().entity_mut(plain).insert(layers);
        stage.world().resource_mut::<ProgressiveLighting>().enabled = false;
        stage.update();
        let without = stage.read(&map);
        stage.world().resource_mut::<ProgressiveLighting>().enabled = true;
        stage.shine(5);
        let with = stage.read(&map);
        save(&with, "minimap");
        assert!(with.iter().any(|pixel| pixel.max_element() > 0.05), "not black");
        assert_eq!(Stage::apart(&without, &with), 0.0);
    }
}

#[test]
fn shadows_fall_where_their_casters_are_seen() {
    // Two refining cameras; what only the second shows casts no shadow for the first.
    let alone = |boxed: bool| {
        let mut stage = stage();
        let camera = stage.camera(EYES[0], TO);
        if boxed {
            let cuboid = (stage.mesh(Cuboid::from_length(0.5)), stage.matte(Color::WHITE));
            let on = RenderLayers::layer(1);
            stage.spawn((cuboid, Transform::from_xyz(0.9, 0.6, 0.8), on));
            let other = stage.target(UVec2::splat(SIZE));
            let second = stage.plain_camera(&other, EYES[0], TO);
            let layers = RenderLayers::from_layers(&[0, 1]);
            stage.world().entity_mut(second).insert((ProgressiveCamera::default(), layers));
            stage.refine(second);
            stage.refine(camera);
            (stage.floats(), stage.read(&other))
        } else {
            stage.refine(camera);
            let picture = stage.floats();
            (picture.clone(), picture)
        }
    };
    let (without, _) = alone(false);
    let (first, second) = alone(true);
    save(&first, "layer-0");
    save(&second, "layer-1");
    let apart = Stage::apart(&without, &first);
    assert!(apart < 2e-3, "{apart}");
    assert!(Stage::apart(&first, &second) > 0.1, "the second sees the box");
}

#[test]
fn each_of_several_cameras_refines_to_what_it_sees_alone() {
    let half = UVec2::new(SIZE / 2, SIZE);
    let alone = EYES.map(|eye| {
        let mut stage = stage();
        let target = stage.target(half);
        let camera = stage.plain_camera(&target, eye, TO);
        stage.world().entity_mut(camera).insert(ProgressiveCamera::default());
        stage.refine(camera);
        stage.read(&target)
    });
    // A split screen, and an image of its own for the second eye.
    for split in [true, false] {
        let mut stage = stage();
        let image = stage.target(if split { UVec2::splat(SIZE) } else { half });
        let other = if split { image.clone() } else { stage.target(half) };
        let cameras = [(image.clone(), 0), (other.clone(), 1)].map(|(target, i)| {
            let camera = stage.plain_camera(&target, EYES[i], TO);
            let viewport = split.then(|| Viewport {
                physical_position: UVec2::new(i as u32 * half.x, 0),
                physical_size: half,
                ..default()
            });
            let order = i as isize;
            let camera_component = Camera { viewport, order, ..default() };
            stage
                .world()
                .entity_mut(camera)
                .insert((ProgressiveCamera::default(), camera_component));
            // They come to rest one after the other.
            for _ in 0..7 {
                stage.update();
            }
            camera
        });
        stage.refine(cameras[0]);
        stage.refine(cameras[1]);
        let pictures: Vec<Vec<Vec3>> = if split {
            let both = stage.read(&image);
            save(&both, "split");
            let side = |side: u32| {
                let inside = |i: &usize| (*i as u32 % SIZE) / half.x == side;
                (0..both.len()).filter(inside).map(|i| both[i]).collect()
            };
            vec![side(0), side(1)]
        } else {
            vec![stage.read(&image), stage.read(&other)]
        };
        for (i, picture) in pictures.iter().enumerate() {
            let apart = Stage::apart(picture, &alone[i]);
            println!("split {split}, camera {i}: {apart}");
            // Half floats and another order of the frames in the mean.
            assert!(apart < 4e-3, "camera {i}, split {split}: {apart}");
        }
        // One moves, the other rests.
        let before = if split { None } else { Some(stage.read(&image)) };
        for step in 0..6 {
            let mut moved = stage.world().get_mut::<Transform>(cameras[1]).unwrap();
            moved.translation.x += 0.01 * (step + 1) as f32;
            stage.update();
            let world = stage.world();
            assert!(world.get::<Refinement>(cameras[0]).unwrap().is_refined(), "it rests");
            assert!(!world.get::<Refinement>(cameras[1]).unwrap().is_refined(), "it moves");
        }
        if let Some(before) = before {
            assert_eq!(Stage::apart(&before, &stage.read(&image)), 0.0);
        }
    }
}

#[test]
fn another_size_is_another_picture() {
    let half = UVec2::new(SIZE / 2, SIZE);
    let refined = |sizes: &[UVec2]| {
        let mut stage = stage();
        let camera = stage.camera(EYES[0], TO);
        let mut picture = Vec::new();
        for size in sizes {
            let target = stage.target(*size);
            stage.world().entity_mut(camera).insert(RenderTarget::from(target.clone()));
            // The camera learns of it with the next frame.
            stage.update();
            stage.update();
            stage.refine(camera);
            picture = stage.read(&target);
        }
        picture
    };
    let once = refined(&[half]);
    let resized = refined(&[UVec2::splat(SIZE), half]);
    let apart = Stage::apart(&once, &resized);
    assert!(apart < 4e-3, "{apart}");
}
