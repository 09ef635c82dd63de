//! Bindings from files: hot reload, what is wrong with them, the user's own.

use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use bevy::prelude::*;
use farlight::controls::{
    ControlsInForce, ControlsPlugin, ControlsStatus, RebindState, Rebinding, Resolve, UserFile,
    actions::*,
};
use farlight_bindings::{Device, Xr};

use crate::player::Player;

/// A folder that goes when the test does.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("farlight-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn plugin(user: &Path) -> ControlsPlugin {
    let user_file = UserFile::At(user.to_owned());
    ControlsPlugin { gamepads: false, user_file, ..default() }
}

fn wait(player: &mut Player, what: &str, until: impl Fn(&mut Player) -> bool) {
    let start = Instant::now();
    while !until(player) {
        assert!(start.elapsed() < Duration::from_secs(60), "{what} never happens");
        std::thread::sleep(Duration::from_millis(2));
        player.frame();
    }
}

fn status(player: &Player) -> ControlsStatus {
    player.app.world().resource::<ControlsStatus>().clone()
}

#[test]
fn files_are_reloaded_and_bad_ones_change_nothing() {
    let folder = Folder::new("controls-reload");
    let file = folder.path().join("game.controls.ron");
    let write = |text: &str| fs::write(&file, text).unwrap();
    write("ControlsSettings(bindings: {\"menu\": (keyboard_mouse: [\"KeyY\"])})");
    let controls = ControlsPlugin {
        file: Some("game.controls.ron".into()),
        user_file: UserFile::Nowhere,
        gamepads: false,
    };
    let mut player = Player::with_assets(controls, folder.path());
    let menu = |player: &mut Player| {
        let in_force = player.app.world().resource::<ControlsInForce>();
        in_force.bindings.of("menu", Device::KeyboardMouse)[0].input_text()
    };
    wait(&mut player, "loading", |player| menu(player) == "KeyY");
    // W is held while bindings change: it goes on; Y as a menu is new, and it is already down.
    player.key(KeyCode::KeyW, true);
    player.key(KeyCode::KeyU, true);
    player.frame();
    assert!(player.held::<Walk>());
    write("ControlsSettings(bindings: {\"menu\": (keyboard_mouse: [\"KeyU\"])})");
    let reload = |player: &mut Player| {
        player.app.world().resource::<AssetServer>().reload("game.controls.ron");
    };
    reload(&mut player);
    wait(&mut player, "reloading", |player| menu(player) == "KeyU");
    player.frames(2);
    assert!(player.held::<Walk>() && !player.held::<Menu>());
    let conflicts = status(&player).conflicts;
    assert!(conflicts.iter().any(|conflict| conflict.input == "KeyU"), "{conflicts:?}");
    for (text, place) in [
        ("ControlsSettings(\n  invert_zom: true)", "game.controls.ron:2:"),
        ("ControlsSettings(\n  sensitivity: 100.0)", "game.controls.ron:2:"),
        ("ControlsSettings(bindings: {\n\"menu\": (gamepad: [\"KeyM\"])})", "game.controls.ron:2:"),
    ] {
        write(text);
        reload(&mut player);
        let told = |player: &mut Player| {
            let problems = status(player).problems;
            problems.iter().any(|problem| problem.contains(place))
        };
        wait(&mut player, text, told);
        assert_eq!(menu(&mut player), "KeyU");
        write("ControlsSettings(bindings: {\"menu\": (keyboard_mouse: [\"KeyU\"])})");
        reload(&mut player);
        wait(&mut player, "mending it", |player| status(player).problems.is_empty());
    }
    player.key(KeyCode::KeyW, false);
    player.frame();
    assert!(!player.held::<Walk>());
}

fn state(player: &Player) -> RebindState {
    player.app.world().resource::<Rebinding>().state().clone()
}

fn tell(player: &mut Player, tell: impl FnOnce(&mut Rebinding)) {
    tell(&mut player.app.world_mut().resource_mut::<Rebinding>());
}

fn tap(player: &mut Player, key: KeyCode) {
    player.key(key, true);
    player.frame();
    player.key(key, false);
    player.frame();
}

fn bound(player: &Player, action: &str, device: Device) -> Vec<String> {
    let bindings = &player.app.world().resource::<ControlsInForce>().bindings;
    bindings.of(action, device).iter().map(|binding| binding.input_text()).collect()
}

#[test]
fn what_is_rebound_is_saved_and_comes_back() {
    let folder = Folder::new("controls-user");
    let file = folder.path().join("deep/controls.ron");
    let mut player = Player::with(plugin(&file));
    let device = Device::KeyboardMouse;
    tell(&mut player, |rebinding| rebinding.start("menu", device, 0));
    player.frame();
    assert!(matches!(state(&player), RebindState::Waiting { .. }));
    player.key(KeyCode::ControlLeft, true);
    player.frame();
    tap(&mut player, KeyCode::KeyY);
    assert!(matches!(state(&player), RebindState::Done { .. }), "{:?}", state(&player));
    assert_eq!(bound(&player, "menu", device), ["Ctrl+KeyY"]);
    assert!(!player.held::<Menu>(), "nobody hears what is chosen");
    player.key(KeyCode::ControlLeft, false);
    player.frame();
    // Esc changes nothing.
    tell(&mut player, |rebinding| rebinding.start("help", device, 0));
    tap(&mut player, KeyCode::Escape);
    assert_eq!(state(&player), RebindState::Cancelled);
    assert!(!player.held::<Quit>());
    // What does something else is asked about.
    tell(&mut player, |rebinding| rebinding.start("help", device, 1));
    tap(&mut player, KeyCode::KeyP);
    let RebindState::Conflict { with, .. } = state(&player) else {
        panic!("{:?}", state(&player));
    };
    assert_eq!(with, ["toggle_progressive"]);
    tell(&mut player, |rebinding| rebinding.resolve(Resolve::Replace));
    player.frame();
    assert_eq!(bound(&player, "help", device), ["F1", "KeyP"]);
    assert!(bound(&player, "toggle_progressive", device).is_empty());
    // Four keys are asked for one by one.
    tell(&mut player, |rebinding| rebinding.start("walk", device, 0));
    for key in [KeyCode::Numpad0, KeyCode::NumpadEnter, KeyCode::NumpadDecimal] {
        tap(&mut player, key);
        assert!(matches!(state(&player), RebindState::Waiting { .. }), "{:?}", state(&player));
    }
    tap(&mut player, KeyCode::NumpadMultiply);
    tell(&mut player, |rebinding| rebinding.resolve(Resolve::KeepBoth));
    player.frame();
    assert_eq!(
        bound(&player, "walk", device),
        ["Numpad0|NumpadEnter|NumpadDecimal|NumpadMultiply"]
    );
    player.key(KeyCode::NumpadEnter, true);
    player.frame();
    let walked = player.axis2_of::<Walk>();
    assert!((walked.x - 1.5 * crate::player::FRAME).abs() < 1e-4, "as fast as before: {walked}");
    player.key(KeyCode::NumpadEnter, false);
    // A stick as a whole, with its speed.
    let pad = player.connect("Test pad");
    tell(&mut player, |rebinding| rebinding.start("orbit", Device::Gamepad, 0));
    player.axis(pad, GamepadAxis::RightStickX, 0.9);
    player.frame();
    if matches!(state(&player), RebindState::Conflict { .. }) {
        tell(&mut player, |rebinding| rebinding.resolve(Resolve::KeepBoth));
        player.frame();
    }
    assert_eq!(bound(&player, "orbit", Device::Gamepad), ["RightStick"]);
    player.app.world_mut().resource_mut::<ControlsInForce>().bindings.invert_zoom = true;
    tell(&mut player, Rebinding::save);
    wait(&mut player, "saving", |_| file.exists());
    let text = fs::read_to_string(&file).unwrap();

    // Another day.
    let mut again = Player::with(plugin(&file));
    assert_eq!(bound(&again, "menu", device), ["Ctrl+KeyY"], "{text}");
    assert_eq!(bound(&again, "help", device), ["F1", "KeyP"]);
    assert!(bound(&again, "toggle_progressive", device).is_empty());
    assert!(again.app.world().resource::<ControlsInForce>().bindings.invert_zoom);
    tell(&mut again, |rebinding| rebinding.reset("menu", device));
    again.frame();
    assert_eq!(bound(&again, "menu", device), ["KeyM"]);
    tell(&mut again, Rebinding::reset_all);
    again.frame();
    assert_eq!(bound(&again, "help", device), ["F1"]);
}

#[test]
fn a_damaged_user_file_is_put_aside() {
    let folder = Folder::new("controls-damaged");
    let file = folder.path().join("controls.ron");
    fs::write(&file, "ControlsSettings(").unwrap();
    let player = Player::with(plugin(&file));
    let problems = status(&player).problems;
    assert!(problems.len() == 1 && problems[0].contains("controls.ron:1:"), "{problems:?}");
    assert!(!file.exists() && folder.path().join("controls.ron.damaged").exists());
    assert_eq!(bound(&player, "menu", Device::KeyboardMouse), ["KeyM"]);
}

#[test]
fn what_does_not_fit_is_refused_with_the_reason() {
    let mut player = Player::new();
    tell(&mut player, |rebinding| rebinding.start("menu", Device::KeyboardMouse, 0));
    player.scroll(bevy::input::mouse::MouseScrollUnit::Line, 1.0);
    player.frame();
    let RebindState::Waiting { refused: Some(reason), .. } = state(&player) else {
        panic!("{:?}", state(&player));
    };
    assert!(reason.contains("one button"), "{reason}");
    // Other devices are not listened to.
    player.hold(farlight_bindings::Profile::Touch);
    player.hand(farlight_bindings::Hand::Left, Xr::Primary, 1.0, 0.0);
    player.frames(2);
    assert!(matches!(state(&player), RebindState::Waiting { .. }));
}
