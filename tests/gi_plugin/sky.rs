//! What the backend is told of the sky.

use std::sync::Arc;

use bevy::{
    asset::RenderAssetUsages,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use farlight::{
    gi::{
        ExtractedScene,
        solver::{
            SceneChange,
            scene::{self, Sky, SkyImage},
            session::{SessionChange, SnapshotId},
        },
    },
    prelude::*,
};

use crate::{Flat, mock::scene_changes};

fn claim(flat: &mut Flat, radiance: SkyRadiance, direct: DirectSky) {
    let mut sky = flat.world().resource_mut::<SkySource>();
    SkySource::claim(&mut sky, "a test", radiance, direct).unwrap();
}

fn constant(radiance: f32) -> SkyRadiance {
    SkyRadiance::Constant(Vec3::splat(radiance))
}

/// An image of which the first texel is brighter.
fn image(flat: &mut Flat, first: f32) -> Handle<Image> {
    let (width, height) = (8, 4);
    let texel = |i| if i == 0 { first } else { 0.5_f32 };
    let data = (0..width * height).flat_map(|i| [texel(i), 0.25, 0.125, 1.0]);
    let image = Image::new(
        Extent3d { width, height, depth_or_array_layers: 1 },
        TextureDimension::D2,
        data.flat_map(f32::to_ne_bytes).collect(),
        TextureFormat::Rgba32Float,
        RenderAssetUsages::MAIN_WORLD,
    );
    flat.world().resource_mut::<Assets<Image>>().add(image)
}

fn snapshot(flat: &mut Flat) -> SnapshotId {
    flat.world().resource::<ExtractedScene>().snapshot
}

/// Frames until the image has been taken over.
fn wait_for_image(flat: &mut Flat) -> Arc<SkyImage> {
    for _ in 0..2000 {
        flat.app.update();
        if let Sky::Image { image, .. } = &flat.world().resource::<ExtractedScene>().scene.sky {
            return image.clone();
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("the sky's image doesn't arrive");
}

#[test]
fn the_sky_is_counted_once_and_follows_its_source() {
    let mut flat = Flat::new();
    *flat.world().resource_mut::<SkySource>() = SkySource::constant(Vec3::splat(3.0));
    flat.app.update();
    let changes = flat.mock.take_changes();
    assert!(
        matches!(&changes[..], [SessionChange::Scene(SceneChange::SetSky(Sky::Constant(c)))] if c.x == 3.0),
        "{changes:?}"
    );
    flat.app.update();
    assert!(flat.mock.take_changes().is_empty());
    // The same again, whether or not it looks like a change.
    *flat.world().resource_mut::<SkySource>() = SkySource::constant(Vec3::splat(3.0));
    flat.app.update();
    assert!(flat.mock.take_changes().is_empty());
}

#[test]
fn lights_that_show_the_direct_part_are_one_change_of_light() {
    let mut flat = Flat::new();
    claim(&mut flat, constant(2.0), DirectSky::Solved);
    flat.app.update();
    flat.mock.take_changes();
    for (direct, expected) in [
        (DirectSky::ByLights, scene::DirectSky::LeftOut),
        (DirectSky::Solved, scene::DirectSky::Included),
    ] {
        claim(&mut flat, constant(2.0), direct);
        flat.app.update();
        let changes = flat.mock.take_changes();
        assert!(
            matches!(&changes[..], [SessionChange::Scene(SceneChange::SetDirectSky(to))] if *to == expected),
            "{changes:?}"
        );
        assert!(scene_changes(&changes)[0].is_light_only());
        assert_eq!(flat.world().resource::<ExtractedScene>().scene.direct_sky, expected);
        // An owner that claims it every frame changes nothing.
        for _ in 0..3 {
            claim(&mut flat, constant(2.0), direct);
            flat.app.update();
        }
        assert!(flat.mock.take_changes().is_empty());
    }

    // Whoever gives the sky back takes the lights away.
    claim(&mut flat, constant(2.0), DirectSky::ByLights);
    flat.app.update();
    SkySource::release(&mut flat.world().resource_mut::<SkySource>(), "a test");
    flat.app.update();
    let direct = flat.world().resource::<ExtractedScene>().scene.direct_sky;
    assert_eq!(direct, scene::DirectSky::Included);
}

#[test]
fn a_new_backend_is_told_of_it() {
    let mut flat = Flat::new();
    claim(&mut flat, constant(2.0), DirectSky::ByLights);
    flat.app.update();
    flat.mock.take_changes();
    flat.mock.lock().lost = true;
    flat.app.update();
    let changes = flat.mock.take_changes();
    let told = scene_changes(&changes)
        .iter()
        .any(|c| matches!(c, SceneChange::SetDirectSky(scene::DirectSky::LeftOut)));
    assert!(told, "{changes:?}");
}

#[test]
fn a_sky_that_turns_or_grows_brighter_names_the_same_image() {
    let mut flat = Flat::new();
    let image = image(&mut flat, 100.0);
    let sky = |turn: f32, brightness: f32| {
        let rotation = Quat::from_rotation_y(turn);
        SkyRadiance::Equirect { image: image.clone(), rotation, brightness }
    };
    claim(&mut flat, sky(0.0, 1.0), DirectSky::ByLights);
    let first = wait_for_image(&mut flat);
    assert_eq!(first.texels[0], Vec3::new(100.0, 0.25, 0.125));
    flat.mock.take_changes();
    for (turn, brightness) in [(0.5, 1.0), (0.5, 7.0), (0.6, 8.0)] {
        claim(&mut flat, sky(turn, brightness), DirectSky::ByLights);
        flat.app.update();
        let changes = flat.mock.take_changes();
        let [SessionChange::Scene(SceneChange::SetSky(Sky::Image { image, rotation, scale }))] =
            &changes[..]
        else {
            panic!("{changes:?}")
        };
        assert!(Arc::ptr_eq(image, &first), "it isn't converted, nor sent, again");
        assert_eq!((*rotation, *scale), (Quat::from_rotation_y(turn), brightness));
        claim(&mut flat, sky(turn, brightness), DirectSky::ByLights);
        flat.app.update();
        assert!(flat.mock.take_changes().is_empty());
    }
    // The same pixels again are no other sky, other pixels are.
    let now = snapshot(&mut flat);
    let mut images = flat.world().resource_mut::<Assets<Image>>();
    images.get_mut(&image).unwrap();
    for _ in 0..50 {
        flat.app.update();
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert_eq!(snapshot(&mut flat), now);
    let mut images = flat.world().resource_mut::<Assets<Image>>();
    images.get_mut(&image).unwrap().data.as_mut().unwrap()[..4]
        .copy_from_slice(&50.0_f32.to_ne_bytes());
    for _ in 0..2000 {
        flat.app.update();
        std::thread::sleep(std::time::Duration::from_millis(1));
        if snapshot(&mut flat) > now {
            break;
        }
    }
    assert_eq!(wait_for_image(&mut flat).texels[0].x, 50.0);
}

#[test]
fn what_is_no_light_counts_as_black() {
    let mut flat = Flat::new();
    let image = image(&mut flat, 1.0);
    let black = |flat: &mut Flat| {
        flat.app.update();
        flat.world().resource::<ExtractedScene>().scene.sky.is_black()
    };
    let sky = |brightness: f32, rotation: Quat| SkyRadiance::Equirect {
        image: image.clone(),
        rotation,
        brightness,
    };
    claim(&mut flat, sky(1.0, Quat::IDENTITY), DirectSky::Solved);
    wait_for_image(&mut flat);
    assert!(!black(&mut flat));
    let nowhere = Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0);
    for (brightness, rotation) in [
        (-1.0, Quat::IDENTITY),
        (f32::NAN, Quat::IDENTITY),
        (f32::INFINITY, Quat::IDENTITY),
        (1.0, nowhere),
    ] {
        claim(&mut flat, sky(brightness, rotation), DirectSky::Solved);
        assert!(black(&mut flat), "{brightness} {rotation}");
        claim(&mut flat, sky(1.0, Quat::IDENTITY), DirectSky::Solved);
        assert!(!black(&mut flat));
    }
    for radiance in [-1.0, f32::NAN, f32::INFINITY] {
        claim(&mut flat, constant(radiance), DirectSky::Solved);
        assert!(black(&mut flat), "{radiance}");
        claim(&mut flat, constant(1.0), DirectSky::Solved);
        assert!(!black(&mut flat));
    }
}
