//! Actions get other inputs by the panel's buttons.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant},
};

use bevy::prelude::*;
use farlight::{
    controls::{RebindState, Rebinding, UserFile},
    panel::{PanelSettings, egui},
    prelude::*,
};
use farlight_bindings::{ACTIONS, Device};

use crate::{
    stage::{Stage, controls},
    support,
};

const KEYS: Device = Device::KeyboardMouse;

fn open(user_file: &Path) -> Stage {
    let settings = PanelSettings { hint: false, ..default() };
    let plugins = FarlightPlugins.set(controls(UserFile::At(user_file.to_owned())));
    let mut stage = Stage::with(UVec2::new(960, 800), settings, plugins);
    let mut state = stage.world().resource_mut::<PanelState>();
    (state.menu, state.unfold) = (true, Some("Controls"));
    stage.frames(12);
    stage
}

fn state(stage: &mut Stage) -> RebindState {
    stage.world().resource::<Rebinding>().state().clone()
}

fn bound(stage: &mut Stage, action: &str) -> Vec<String> {
    let bindings = &stage.world().resource::<ControlsInForce>().bindings;
    bindings.of(action, KEYS).iter().map(|binding| binding.input_text()).collect()
}

/// Presses the row of an action; what is asked for then.
fn press_row(stage: &mut Stage, action: &str) {
    let row = ACTIONS.iter().position(|info| info.name == action).unwrap();
    let rows = stage.buttons();
    assert!(rows.len() > row, "{rows:?} of {:?}", stage.all());
    stage.click(rows[row].center());
    let RebindState::Waiting { target, .. } = state(stage) else { panic!("{:?}", state(stage)) };
    assert_eq!((target.action.as_str(), target.device, target.slot), (action, KEYS, 0));
}

/// The user's file, once it says something.
fn saved(stage: &mut Stage, file: &Path, what: &str) -> String {
    let start = Instant::now();
    loop {
        stage.frames(1);
        let text = fs::read_to_string(file).unwrap_or_default();
        if text.contains(what) {
            return text;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "{what} is never saved: {text}");
    }
}

#[test]
fn a_row_is_pressed_a_key_comes_and_is_saved() {
    let folder = support::scratch("panel_rebind");
    let file = folder.join("controls.ron");
    fs::create_dir_all(&folder).unwrap();
    let _ = fs::remove_file(&file);
    let mut stage = open(&file);
    press_row(&mut stage, "next_material");
    stage.frames(2);
    assert_eq!(stage.picture("rebind_waiting.png").problem(), None);
    stage.tap(KeyCode::KeyY);
    assert!(matches!(state(&mut stage), RebindState::Done { .. }), "{:?}", state(&mut stage));
    assert_eq!(bound(&mut stage, "next_material"), ["KeyY"]);
    let text = saved(&mut stage, &file, "KeyY");
    assert!(text.contains("next_material"), "{text}");

    // What does something else is asked about, and a button answers.
    press_row(&mut stage, "next_material");
    stage.tap(KeyCode::KeyP);
    let RebindState::Conflict { with, .. } = state(&mut stage) else {
        panic!("{:?}", state(&mut stage));
    };
    assert_eq!(with, ["toggle_progressive"]);
    stage.frames(2);
    stage.picture("rebind_conflict.png");
    let [replace, ..] = answers(&mut stage);
    stage.click(replace.center());
    stage.frames(2);
    assert!(matches!(state(&mut stage), RebindState::Done { .. }), "{:?}", state(&mut stage));
    assert_eq!(bound(&mut stage, "next_material"), ["KeyP"]);
    assert!(bound(&mut stage, "toggle_progressive").is_empty());
    let text = saved(&mut stage, &file, "KeyP");
    assert!(text.contains("toggle_progressive"), "{text}");

    // Esc changes nothing, and the menu stays open.
    press_row(&mut stage, "next_material");
    stage.tap(KeyCode::Escape);
    assert_eq!(state(&mut stage), RebindState::Cancelled);
    assert!(stage.world().resource::<PanelState>().menu);
    assert_eq!(bound(&mut stage, "next_material"), ["KeyP"]);

    // Another day.
    let mut again = open(&file);
    assert_eq!(bound(&mut again, "next_material"), ["KeyP"]);
    assert!(bound(&mut again, "toggle_progressive").is_empty());
    fs::remove_dir_all(&folder).unwrap();
}

/// Replace, keep both, cancel: the only buttons in one line.
fn answers(stage: &mut Stage) -> [egui::Rect; 3] {
    let rects = stage.all();
    let line = |at: &egui::Rect| {
        let beside = |other: &&egui::Rect| {
            (other.top() - at.top()).abs() < 0.5 && (other.height() - at.height()).abs() < 0.5
        };
        rects.iter().filter(beside).count() == 3
    };
    let mut found: Vec<_> = rects.iter().copied().filter(line).collect();
    found.sort_by(|a, b| a.left().total_cmp(&b.left()));
    found.try_into().unwrap_or_else(|found| panic!("{found:?} of {rects:?}"))
}
