//! Panels in the world behind what is nearer.

use bevy::{color::palettes::css::WHITE, prelude::*};
use farlight::{panel::PanelSettings, prelude::*};

use crate::{stage::Stage, support::headless::Picture};

const SIZE: u32 = 400;

/// A panel with a white plate before its right half, and another one behind it.
fn stage(through: f32, msaa: Msaa) -> Stage {
    let settings = PanelSettings { place: PanelPlace::World, hint: false, through, ..default() };
    let mut stage = Stage::new(UVec2::splat(SIZE), settings);
    let camera = stage.camera;
    let world = stage.world();
    world.entity_mut(camera).insert(msaa);
    let material = StandardMaterial { base_color: WHITE.into(), unlit: true, ..default() };
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(material);
    let plate = world.resource_mut::<Assets<Mesh>>().add(Rectangle::new(0.25, 0.25));
    for place in [Vec3::new(0.13, 0.0, -0.6), Vec3::new(-0.9, 0.0, -4.0)] {
        let parts = (Mesh3d(plate.clone()), MeshMaterial3d(material.clone()));
        world.spawn((parts, Transform::from_translation(place)));
    }
    world.resource_mut::<PanelState>().menu = true;
    stage.frames(12);
    stage
}

/// Mean of the brightness, 0 to 255, in the middle of the nearer plate, and that of the panel in the
/// same place on the left.
fn halves(picture: &Picture) -> [f64; 2] {
    let mean = |from: u32| {
        let pixels = (180..220).flat_map(|y| (from..from + 40).map(move |x| y * SIZE + x));
        let values = pixels.map(|at| f64::from(picture.pixels[at as usize][1]));
        values.sum::<f64>() / 1600.0
    };
    [mean(270), mean(60)]
}

#[test]
fn what_is_nearer_covers_it_as_far_as_settings_say() {
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let covered = |through: f32| {
            let picture = stage(through, msaa).picture(&format!("covered_{through}_{msaa:?}.png"));
            halves(&picture)
        };
        let ([hidden, beside], [half, _], [shown, same]) =
            (covered(0.0), covered(0.5), covered(1.0));
        let what =
            format!("{msaa:?}: {hidden:.0}, {half:.0}, {shown:.0} beside {beside:.0}, {same:.0}");
        assert!(hidden > 150.0, "the plate alone is seen: {what}");
        assert!(half > shown + 30.0 && half < hidden - 30.0, "{what}");
        assert!(shown < 120.0 && (beside - same).abs() < 1.0, "{what}");
    }
}

#[test]
fn by_default_it_can_be_read_behind_a_white_thing() {
    let mut stage = stage(PanelSettings::default().through, Msaa::Off);
    let picture = stage.picture("covered_default.png");
    let luminance = |at: u32| {
        let linear = |v: u8| {
            let v = f64::from(v) / 255.0;
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        };
        let [red, green, blue] = picture.pixels[at as usize];
        0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue)
    };
    let pixels = (140..260).flat_map(|y| (230..330).map(move |x| y * SIZE + x));
    let mut values: Vec<_> = pixels.map(luminance).collect();
    values.sort_by(f64::total_cmp);
    let part = |part: f64| values[((values.len() - 1) as f64 * part) as usize];
    let contrast = (part(0.995) + 0.05) / (part(0.3) + 0.05);
    println!("contrast behind white: {contrast:.1}");
    // WCAG's AA.
    assert!(contrast >= 4.5, "{contrast}");
}
