//! Panels without a pointer.

use bevy::{
    input::gamepad::{
        GamepadConnection, GamepadConnectionEvent, RawGamepadButtonChangedEvent, RawGamepadEvent,
    },
    prelude::*,
};
use farlight::{panel::PanelSettings, prelude::*};

use crate::stage::Stage;

/// Walks down until the slider of the brightness has the focus, moves it, and goes on to the switch above
/// it. `tap` says next, previous, more, press.
fn walk(stage: &mut Stage, on_screen: bool, mut tap: impl FnMut(&mut Stage, usize)) {
    let switch = stage.switch(on_screen);
    let mut steps = 0;
    loop {
        tap(stage, 0);
        steps += 1;
        assert!(steps < 10, "the switch is not reached");
        if stage.focused(on_screen) == Some(switch) {
            break;
        }
    }
    let before = stage.lamp();
    tap(stage, 3);
    assert_ne!(stage.lamp().on, before.on, "pressed");
    tap(stage, 0);
    tap(stage, 2);
    let after = stage.lamp();
    assert!(after.brightness > before.brightness, "{} {}", before.brightness, after.brightness);
    stage.frames(6);
    stage.picture(if on_screen { "focus.png" } else { "world_focus.png" });
    tap(stage, 1);
    assert_eq!(stage.focused(on_screen), Some(switch), "and back");
}

#[test]
fn with_the_keyboard_alone() {
    for place in [PanelPlace::Screen, PanelPlace::World] {
        let settings = PanelSettings { place, ..default() };
        let mut stage = Stage::new(UVec2::new(960, 600), settings);
        stage.tap(KeyCode::KeyM);
        stage.frames(3);
        walk(&mut stage, place == PanelPlace::Screen, |stage, way| {
            use KeyCode::{ArrowDown, ArrowRight, ArrowUp, Enter};
            stage.tap([ArrowDown, ArrowUp, ArrowRight, Enter][way]);
        });
    }
}

#[test]
fn with_a_gamepad_alone() {
    let mut stage = Stage::new(UVec2::new(960, 600), PanelSettings::default());
    let gamepad = stage.world().spawn_empty().id();
    let connection =
        GamepadConnection::Connected { name: "pad".into(), vendor_id: None, product_id: None };
    let event = GamepadConnectionEvent::new(gamepad, connection);
    stage.world().write_message(event.clone());
    stage.world().write_message(RawGamepadEvent::Connection(event));
    stage.frames(2);
    let press = |stage: &mut Stage, button: GamepadButton| {
        for value in [1.0, 0.0] {
            let event = RawGamepadButtonChangedEvent::new(gamepad, button, value);
            stage.world().write_message(RawGamepadEvent::Button(event));
            stage.frames(1);
        }
    };
    press(&mut stage, GamepadButton::Start);
    assert!(stage.world().resource::<PanelState>().menu);
    stage.frames(3);
    walk(&mut stage, true, |stage, way| {
        use GamepadButton::{DPadDown, DPadRight, DPadUp, South};
        press(stage, [DPadDown, DPadUp, DPadRight, South][way]);
    });
    press(&mut stage, GamepadButton::East);
    assert!(!stage.world().resource::<PanelState>().menu, "back closes");
}
