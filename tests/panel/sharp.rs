//! Text of the world's panel is as sharp as that of the screen's.

use bevy::prelude::*;
use farlight::{panel::PanelSettings, prelude::*};

use crate::{stage::Stage, support::headless::Picture};

fn luminance(pixel: [u8; 3]) -> f64 {
    let linear = |v: u8| {
        let v = f64::from(v) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * linear(pixel[0]) + 0.7152 * linear(pixel[1]) + 0.0722 * linear(pixel[2])
}

/// Contrast of text after WCAG 2 (1 to 21), and the width of its sharpest edges in pixels: how far the
/// whole contrast would take at their slope. Of the 1 % of pixels with the steepest slopes.
fn text(picture: &Picture, from: UVec2, to: UVec2) -> (f64, f64) {
    let at = |x: u32, y: u32| luminance(picture.pixels[(y * picture.width + x) as usize]);
    let mut values = Vec::new();
    let mut slopes = Vec::new();
    for y in from.y..to.y {
        for x in from.x..to.x - 1 {
            values.push(at(x, y));
            slopes.push((at(x + 1, y) - at(x, y)).abs());
        }
    }
    values.sort_by(f64::total_cmp);
    slopes.sort_by(f64::total_cmp);
    let part = |sorted: &[f64], part: f64| sorted[((sorted.len() - 1) as f64 * part) as usize];
    let (dark, light) = (part(&values, 0.5), part(&values, 0.995));
    ((light + 0.05) / (dark + 0.05), (light - dark) / part(&slopes, 0.99))
}

#[test]
fn letters_are_sharp_and_light_on_dark() {
    let mut stage = Stage::new(UVec2::new(960, 600), PanelSettings::default());
    stage.world().resource_mut::<PanelState>().menu = true;
    stage.frames(12);
    let screen = stage.picture("sharp_screen.png");
    // Labels and values, without the switch's large areas.
    let (contrast, edge) = text(&screen, UVec2::new(604, 120), UVec2::new(740, 280));

    let settings = PanelSettings { place: PanelPlace::World, hint: false, ..default() };
    let mut stage = Stage::new(UVec2::new(800, 800), settings);
    stage.world().resource_mut::<PanelState>().menu = true;
    stage.frames(12);
    let world = stage.picture("sharp_world.png");
    let (in_world, edge_in_world) = text(&world, UVec2::new(100, 160), UVec2::new(330, 360));
    println!(
        "contrast {contrast:.1} and {in_world:.1}, edges {edge:.2} and {edge_in_world:.2} pixels"
    );
    // WCAG's AAA asks for 7.
    assert!(contrast > 7.0 && in_world > 7.0, "{contrast} {in_world}");
    // An edge that is drawn anew by sampling it at another place takes at most one pixel more.
    assert!(edge_in_world < edge + 1.0, "{edge} {edge_in_world}");
}
