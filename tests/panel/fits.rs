//! Help fits on every screen.

use bevy::prelude::*;
use farlight::{panel::PanelSettings, prelude::*};

use crate::{stage::Stage, support::headless::Picture};

/// The part of a picture that is darker than its background: columns and rows, from and to.
fn card(picture: &Picture) -> [u32; 4] {
    let dark = |x: u32, y: u32| picture.pixels[(y * picture.width + x) as usize][2] < 60;
    let (mut left, mut right, mut top, mut bottom) = (picture.width, 0, picture.height, 0);
    for y in 0..picture.height {
        for x in 0..picture.width {
            if dark(x, y) {
                (left, right) = (left.min(x), right.max(x));
                (top, bottom) = (top.min(y), bottom.max(y));
            }
        }
    }
    [left, right, top, bottom]
}

#[test]
fn help_has_as_many_columns_as_fit() {
    for (width, height) in [(1280, 720), (800, 600), (640, 360)] {
        let settings = PanelSettings { place: PanelPlace::Screen, hint: false, ..default() };
        let mut stage = Stage::new(UVec2::new(width, height), settings);
        stage.world().resource_mut::<PanelState>().help = true;
        stage.frames(12);
        let picture = stage.picture(&format!("help_{width}.png"));
        let [left, right, top, bottom] = card(&picture);
        let what = format!("{width} x {height}: {left} to {right}, {top} to {bottom}");
        assert!(left >= 4 && right <= width - 5 && top >= 4 && bottom <= height - 5, "{what}");
        // In the middle, and letters end before its edge.
        assert!(left.abs_diff(width - 1 - right) <= 2, "{what}");
        let light = |x: u32| {
            let column = (top + 40..bottom - 10).map(move |y| (y * width + x) as usize);
            column.filter(|at| picture.pixels[*at][1] > 120).count()
        };
        let margin: usize = (right - 9..right - 1).chain(left + 2..left + 14).map(light).sum();
        assert_eq!(margin, 0, "{what}: something is written on the margin");
    }
}

#[test]
fn the_hint_goes_while_something_is_open() {
    for place in [PanelPlace::Screen, PanelPlace::World] {
        let mut shown = Vec::new();
        for hint in [false, true] {
            let settings = PanelSettings { place, hint, ..default() };
            let mut stage = Stage::new(UVec2::new(480, 480), settings);
            let closed = stage.picture("hint_closed.png");
            stage.world().resource_mut::<PanelState>().menu = true;
            stage.frames(12);
            shown.push([closed, stage.picture(&format!("hint_{hint}.png"))]);
        }
        let [[closed, open], [closed_with, open_with]] = &shown[..] else { unreachable!() };
        // Letters are not placed the same to the last bit.
        let differ = |a: &Picture, b: &Picture| {
            let far = |(a, b): (&[u8; 3], &[u8; 3])| a[1].abs_diff(b[1]) > 30;
            a.pixels.iter().zip(&b.pixels).filter(|pair| far(*pair)).count()
        };
        let (hint, under) = (differ(closed, closed_with), differ(open, open_with));
        assert!(hint > 1000, "{place:?}: the hint has {hint} pixels");
        assert!(under < 20, "{place:?}: {under} pixels of it are under the menu");
    }
}
