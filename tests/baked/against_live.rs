//! The same room, baked and solved live, looks the same from inside.

use std::{f32::consts::PI, time::Duration};

use bevy::{prelude::*, world_serialization::WorldAssetRoot};
use farlight::prelude::*;

use crate::support::{
    assets,
    headless::Headless,
    linear::{camera, read, save, target},
};

/// A picture's edge in pixels.
const SIZE: u32 = 128;

/// Edge of the blocks that are compared: a lightmap of seven texels a metre has softer shadows than a
/// shadow map.
const BLOCK: u32 = 16;

/// The study from beside the sideboard, in cd/m².
fn picture(add: impl FnOnce(&mut App), until: impl FnMut(&mut World) -> bool) -> Vec<Vec3> {
    let headless = Headless::new(UVec2::splat(SIZE), &assets(), |app| {
        app.add_plugins(FarlightPlugins)
            .insert_resource(GlobalAmbientLight::NONE)
            .insert_resource(ClearColor(Color::BLACK))
            .insert_resource(GiSettings {
                page_size: 256,
                max_pages: 1,
                texels_per_metre: 7.0,
                rays_per_texel: 256,
                converged_paths: 1024,
                bounces: 64,
                ..default()
            });
    });
    let mut headless = headless.unwrap_or_else(|problem| panic!("{problem}"));
    headless.set_frame_time(Duration::from_millis(16));
    let image = target(&mut headless.app, UVec2::splat(SIZE));
    let eye = Transform::from_xyz(2.25, 1.55, 1.0).looking_at(Vec3::new(-1.9, 0.8, 0.4), Vec3::Y);
    headless.app.world_mut().spawn((camera(&image), eye));
    add(&mut headless.app);
    let waited = headless.update_until("light", Duration::from_secs(180), until);
    waited.unwrap_or_else(|problem| panic!("{problem}"));
    read(&mut headless, &[&image]).remove(0)
}

/// Mean luminance of each block.
fn blocks(picture: &[Vec3]) -> Vec<f32> {
    let blocks = SIZE / BLOCK;
    (0..blocks * blocks)
        .map(|block| {
            let (left, top) = (block % blocks * BLOCK, block / blocks * BLOCK);
            let pixels = (0..BLOCK * BLOCK).map(|i| (left + i % BLOCK, top + i / BLOCK));
            let sum: Vec3 = pixels.map(|(x, y)| picture[(y * SIZE + x) as usize]).sum();
            sum.dot(Vec3::new(0.2126, 0.7152, 0.0722)) / (BLOCK * BLOCK) as f32
        })
        .collect()
}

#[test]
fn a_baked_room_looks_like_a_solved_one() {
    let baked = picture(
        |app| {
            let world = app.world_mut();
            let manifest = world.resource::<AssetServer>().load("baked/study/study.baked.ron");
            let mut lighting = BakedLighting::new(manifest);
            lighting.scenarios.show("lamp");
            world.spawn((BakedScene("baked/study/study.baked.ron".into()), lighting));
        },
        |world| world.resource::<BakedStatus>().is_ready(),
    );
    let solved = picture(
        |app| {
            let world = app.world_mut();
            let file = GltfAssetLabel::Scene(0).from_asset("baked/study/study.glb");
            let scene = world.resource::<AssetServer>().load(file);
            world.spawn((GiScene, WorldAssetRoot(scene)));
            // As in `assets/baked/study/lights.ron`.
            let (candela, place) = (Vec3::new(95.0, 70.0, 44.0), Vec3::new(-1.95, 1.56, 1.35));
            let color = candela / candela.x;
            world.spawn((
                PointLight {
                    color: Color::linear_rgb(color.x, color.y, color.z),
                    intensity: candela.x * 4.0 * PI,
                    radius: 0.05,
                    range: 20.0,
                    shadow_maps_enabled: true,
                    ..default()
                },
                Transform::from_translation(place),
            ));
        },
        |world| {
            let status = world.resource::<GiStatus>();
            status.receivers == 11 && status.state == GiState::Converged
        },
    );
    for (picture, name) in [(&baked, "baked"), (&solved, "solved")] {
        let bright: Vec<_> = picture.iter().map(|pixel| *pixel / 8.0).collect();
        save(&bright, SIZE, &format!("baked/against_live_{name}.png"));
    }
    let (baked, solved) = (blocks(&baked), blocks(&solved));
    let mut ratios: Vec<_> =
        baked.iter().zip(&solved).map(|(baked, solved)| baked / solved).collect();
    ratios.sort_by(f32::total_cmp);
    let mut errors: Vec<_> = ratios.iter().map(|ratio| (ratio - 1.0).abs()).collect();
    errors.sort_by(f32::total_cmp);
    // Medians: the bake softens shadows by the lamp's size, which shadow maps don't. 1.018 and 0.034 were
    // measured.
    let median = |sorted: &[f32]| sorted[sorted.len() / 2];
    let (ratio, error) = (median(&ratios), median(&errors));
    println!("baked is {ratio} times as bright, median difference of blocks {error}");
    assert!((0.96..1.05).contains(&ratio), "{ratio}");
    assert!(error < 0.06, "{error}");
}
