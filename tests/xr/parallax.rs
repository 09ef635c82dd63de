//! Both eyes see different pictures, and what is where agrees with how far away it is.

use std::{sync::Arc, time::Duration};

use bevy::{pbr::Lightmap, prelude::*};
use farlight::{
    btf::BtfStatus,
    ibl::{EnvironmentState, environment_maps::Environment},
    prelude::*,
};

use crate::stage::{SIZE, Stage, middle, save, seen_at, views};

/// A disc, which faces the head.
const RADIUS: f32 = 0.12;
/// Where it stands in turn: near and far, beside the middle.
const PLACES: [Vec3; 2] = [Vec3::new(0.06, 0.1, -0.8), Vec3::new(-0.2, -0.15, -2.5)];

fn disc(stage: &mut Stage) -> Mesh3d {
    stage.mesh(Circle::new(RADIUS).mesh().resolution(64))
}

/// Measures where the disc is in both eyes' pictures.
fn check(stage: &mut Stage, marker: Entity, head: Isometry3d, mut settle: impl FnMut(&mut Stage)) {
    for place in PLACES {
        let mut transform = stage.world().get_mut::<Transform>(marker).unwrap();
        transform.translation = place;
        // Nearly as large in the picture wherever it is.
        transform.scale = Vec3::splat(-place.z);
        settle(stage);
        compare(stage, place, head);
    }
}

fn compare(stage: &mut Stage, place: Vec3, head: Isometry3d) {
    let pictures = stage.read();
    let views = views(head);
    let seen = [middle(&pictures[0]), middle(&pictures[1])];
    let right = [seen_at(&views[0], place), seen_at(&views[1], place)];
    println!("{place}: {seen:?}, by the angles {right:?}");
    for eye in 0..2 {
        let off = (seen[eye] - right[eye]).length();
        assert!(off < 0.5, "eye {eye}: {} instead of {}", seen[eye], right[eye]);
    }
    let disparity = seen[0].x - seen[1].x;
    let expected = right[0].x - right[1].x;
    assert!((disparity - expected).abs() < 0.5, "{disparity} instead of {expected} pixels");
    assert!((seen[0].y - seen[1].y).abs() < 0.5, "the eyes are at one height");
}

/// How much more to the right the left eye sees a thing than if it were infinitely far away.
#[test]
fn near_things_are_farther_apart() {
    let views = views(Isometry3d::IDENTITY);
    let apart = |z: f32| {
        let place = Vec3::NEG_Z * z;
        seen_at(&views[0], place).x - seen_at(&views[1], place).x
    };
    // The distance of the eyes over the distance of the thing, in pixels per tangent.
    let pixels = SIZE as f32 / (0.7_f32.tan() + 0.9_f32.tan());
    let difference = apart(0.8) - apart(1e6);
    assert!((difference - 0.063 / 0.8 * pixels).abs() < 1e-2, "{difference}");
}

#[test]
fn of_standard_materials() {
    let mut stage = Stage::new();
    stage.sun();
    let mesh = disc(&mut stage);
    let material = stage.material(StandardMaterial::default());
    let marker = stage.spawn((mesh, material, Transform::default()));
    let head = Isometry3d::IDENTITY;
    check(&mut stage, marker, head, |stage| (0..4).for_each(|_| stage.update()));
    // The head is turned and elsewhere.
    let head = Isometry3d::new(Vec3::new(0.1, 0.05, 0.2), Quat::from_rotation_y(0.2));
    stage.look(head);
    check(&mut stage, marker, head, |stage| (0..4).for_each(|_| stage.update()));
}

#[test]
fn of_measured_materials() {
    let mut stage = Stage::new();
    stage.sun();
    let mesh = disc(&mut stage);
    let btf = stage.world().resource::<AssetServer>().load("materials/cloth.fbtf");
    let material = BtfMaterial::new(btf);
    let material = stage.world().resource_mut::<Assets<BtfMaterial>>().add(material);
    let marker = stage.spawn((mesh, MeshMaterial3d(material), Transform::from_xyz(0.0, 0.0, -1.0)));
    let ready = |world: &mut World| {
        let status = world.resource::<BtfStatus>();
        status.waiting == 0 && status.resident > 0
    };
    let patience = Duration::from_secs(60);
    stage.headless.update_until("the material", patience, ready).unwrap();
    check(&mut stage, marker, Isometry3d::IDENTITY, |stage| (0..6).for_each(|_| stage.update()));
}

#[test]
fn of_lightmaps() {
    let mut stage = Stage::new();
    let mut mesh: Mesh = Circle::new(RADIUS).mesh().resolution(64).build();
    let uv = mesh.attribute(Mesh::ATTRIBUTE_UV_0).unwrap().clone();
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uv);
    let mesh = stage.mesh(mesh);
    let material = stage.material(StandardMaterial { lightmap_exposure: 1.0, ..default() });
    // Nothing else shines.
    let white = Image::new_fill(
        bevy::render::render_resource::Extent3d { width: 4, height: 4, depth_or_array_layers: 1 },
        bevy::render::render_resource::TextureDimension::D2,
        &[255; 4],
        bevy::render::render_resource::TextureFormat::Rgba8Unorm,
        bevy::asset::RenderAssetUsages::RENDER_WORLD,
    );
    let image = stage.world().resource_mut::<Assets<Image>>().add(white);
    let lightmap = Lightmap { image, ..default() };
    let marker = stage.spawn((mesh, material, lightmap, Transform::from_xyz(0.0, 0.0, -1.0)));
    (0..4).for_each(|_| stage.update());
    check(&mut stage, marker, Isometry3d::IDENTITY, |stage| (0..4).for_each(|_| stage.update()));
}

/// A stage under an even sky, with a disc before the head; both eyes refine.
fn refining() -> (Stage, Entity) {
    let mut stage = Stage::new();
    let mesh = disc(&mut stage);
    let material = stage.material(StandardMaterial {
        perceptual_roughness: 1.0,
        reflectance: 0.0,
        ..default()
    });
    let marker = stage.spawn((mesh, material, Transform::from_translation(PLACES[0])));
    let map = Environment::from_equirect(8, 4, vec![Vec3::ONE; 32]).unwrap();
    let map = EnvironmentMap(Arc::new(map));
    let environment = stage.world().resource_mut::<Assets<EnvironmentMap>>().add(map);
    stage.world().insert_resource(ProgressiveLighting {
        environment: Some(environment),
        lights: 20,
        shadows: false,
        ..default()
    });
    for eye in stage.eyes {
        stage.world().entity_mut(eye).insert(ProgressiveCamera::default());
    }
    let shines =
        |world: &mut World| world.resource::<EnvironmentStatus>().state == EnvironmentState::Ready;
    stage.headless.update_until("lights", Duration::from_secs(60), shines).unwrap();
    (stage, marker)
}

fn refine(stage: &mut Stage) {
    let eyes = stage.eyes;
    // What was just moved is noticed in the frame after.
    (0..2).for_each(|_| stage.update());
    let refined = move |world: &mut World| {
        eyes.iter().all(|eye| world.get::<Refinement>(*eye).is_some_and(|r| r.is_refined()))
    };
    stage.headless.update_until("refined eyes", Duration::from_secs(120), refined).unwrap();
}

#[test]
fn of_light_that_refines_itself() {
    let (mut stage, marker) = refining();
    check(&mut stage, marker, Isometry3d::IDENTITY, refine);
    // An even sky of 1 cd/m² makes white surfaces shine with 1 cd/m²; 20 lights stand for it. Both
    // eyes' pictures are means of the same lights.
    let place = PLACES[1];
    let views = views(Isometry3d::IDENTITY);
    let pictures = stage.read();
    let [left, right] = [0, 1].map(|eye| {
        let at = seen_at(&views[eye], place).as_uvec2();
        pictures[eye][(at.y * SIZE + at.x) as usize]
    });
    assert!((left - 1.0).abs().max_element() < 0.2, "{left}");
    assert!((left - right).abs().max_element() < 2e-3, "{left} and {right}");
}

/// A head is never still: each eye's picture moves along with its own eye, and no trail shows where
/// the disc was.
#[test]
fn of_light_that_refines_itself_while_the_head_moves() {
    let (mut stage, _) = refining();
    let head = |frame: u32| {
        let swing = frame as f32 * 0.1;
        Isometry3d::new(
            Vec3::new(0.03 * swing.sin(), 0.02 * swing.cos(), 0.0),
            Quat::from_rotation_y(0.05 * swing.sin()),
        )
    };
    for frame in 0..40 {
        stage.look(head(frame));
        stage.update();
        let refining = stage.eyes.map(|eye| *stage.world().get::<Refinement>(eye).unwrap());
        assert!(frame < 2 || refining.iter().all(|r| !r.is_refined()), "it moves");
    }
    // Reading lets frames pass, in which the eyes draw nothing more.
    for eye in stage.eyes {
        stage.world().get_mut::<Camera>(eye).unwrap().is_active = false;
    }
    compare(&mut stage, PLACES[0], head(39));
    let pictures = stage.read();
    save(&pictures[0], "moving_left");
    save(&pictures[1], "moving_right");
    // Nothing is left of where the disc was before; by two pixels its edge may be blurred.
    let view = &views(head(39))[0];
    let pixels = SIZE as f32 / (view.fov.right.tan() - view.fov.left.tan());
    let radius = RADIUS / 0.8 * pixels + 2.0;
    for (eye, picture) in pictures.iter().enumerate() {
        let middle = seen_at(&views(head(39))[eye], PLACES[0]);
        for (i, pixel) in picture.iter().enumerate() {
            let at = Vec2::new((i as u32 % SIZE) as f32, (i as u32 / SIZE) as f32) + 0.5;
            let is_outside = at.distance(middle) > radius;
            assert!(!is_outside || pixel.max_element() < 0.05, "eye {eye}, {at}: {pixel}");
        }
    }
}
