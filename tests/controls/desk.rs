//! Keyboard, mouse and gamepad.

use bevy::{input::mouse::MouseScrollUnit, prelude::*};
use farlight::controls::{InputCapture, actions::*};

use crate::player::{FRAME, Player};

fn close(a: f32, b: f32) {
    assert!((a - b).abs() <= 1e-4 * b.abs().max(1.0), "{a} is not {b}");
}

#[test]
fn a_key_acts_in_the_frame_in_which_it_is_pressed() {
    let mut player = Player::new();
    player.key(KeyCode::ArrowRight, true);
    player.frame();
    assert!(player.started::<NextMaterial>() && player.held::<NextMaterial>());
    player.frame();
    assert!(!player.started::<NextMaterial>() && player.held::<NextMaterial>());
    player.key(KeyCode::ArrowRight, false);
    player.frame();
    assert!(player.ended::<NextMaterial>() && !player.held::<NextMaterial>());
}

#[test]
fn a_key_that_is_tapped_within_a_frame_acts() {
    let mut player = Player::new();
    player.key(KeyCode::KeyM, true);
    player.key(KeyCode::KeyM, false);
    player.frame();
    assert!(player.started::<Menu>());
    player.frame();
    assert!(player.ended::<Menu>());
}

#[test]
fn a_drag_moves_by_its_pixels_and_modifiers_take_it() {
    let mut player = Player::new();
    player.mouse(MouseButton::Left, true);
    player.move_mouse(8.0, -4.0);
    player.frame();
    assert_eq!(player.axis2_of::<Orbit>(), Vec2::new(2.0, 1.0));
    player.frame();
    assert_eq!(player.axis2_of::<Orbit>(), Vec2::ZERO);
    player.key(KeyCode::ControlLeft, true);
    player.move_mouse(8.0, -4.0);
    player.frame();
    assert_eq!(player.axis2_of::<Orbit>(), Vec2::ZERO);
    assert_eq!(player.axis2_of::<Pan>(), Vec2::new(8.0, 4.0));
    // Whoever lets go of Ctrl first wants no other move.
    player.key(KeyCode::ControlLeft, false);
    player.move_mouse(8.0, -4.0);
    player.frame();
    assert_eq!(player.axis2_of::<Orbit>(), Vec2::ZERO);
    assert_eq!(player.axis2_of::<Pan>(), Vec2::ZERO);
    player.mouse(MouseButton::Left, false);
    player.frame();
    player.mouse(MouseButton::Left, true);
    player.move_mouse(4.0, 0.0);
    player.frame();
    assert_eq!(player.axis2_of::<Orbit>(), Vec2::new(1.0, 0.0));
}

#[test]
fn wheels_count_lines_whatever_they_say() {
    let mut player = Player::new();
    player.scroll(MouseScrollUnit::Line, 2.0);
    player.frame();
    close(player.axis_of::<Zoom>(), 2.0);
    player.scroll(MouseScrollUnit::Pixel, -150.0);
    player.frame();
    close(player.axis_of::<Zoom>(), -150.0 / MouseScrollUnit::SCROLL_UNIT_CONVERSION_FACTOR);
    player.frame();
    close(player.axis_of::<Zoom>(), 0.0);
}

#[test]
fn keys_walk_at_one_speed_in_every_direction() {
    let mut player = Player::new();
    player.key(KeyCode::KeyW, true);
    player.frame();
    close(player.axis2_of::<Walk>().y, 1.5 * FRAME);
    player.key(KeyCode::KeyD, true);
    player.frame();
    close(player.axis2_of::<Walk>().length(), 1.5 * FRAME);
    player.key(KeyCode::KeyS, true);
    player.frame();
    close(player.axis2_of::<Walk>().y, 0.0);
    close(player.axis2_of::<Walk>().x, 1.5 * FRAME);
}

#[test]
fn focus_that_is_lost_releases_everything() {
    let mut player = Player::new();
    player.key(KeyCode::KeyW, true);
    player.mouse(MouseButton::Left, true);
    player.frame();
    player.lose_focus();
    player.move_mouse(9.0, 9.0);
    player.frame();
    assert!(!player.held::<Walk>() && !player.held::<Orbit>());
    player.move_mouse(9.0, 9.0);
    player.frame();
    assert!(!player.held::<Orbit>());
    player.mouse(MouseButton::Left, false);
    player.frame();
    player.mouse(MouseButton::Left, true);
    player.key(KeyCode::KeyW, true);
    player.move_mouse(9.0, 9.0);
    player.frame();
    assert!(player.held::<Walk>() && player.held::<Orbit>());
}

#[test]
fn gamepads_act_within_a_frame_and_let_go_when_they_leave() {
    let mut player = Player::new();
    let pad = player.connect("Test pad");
    player.button(pad, GamepadButton::East, 1.0);
    player.axis(pad, GamepadAxis::LeftStickX, 1.0);
    player.frame();
    assert!(player.started::<NextMaterial>());
    close(player.axis2_of::<Orbit>().x, 120.0 * FRAME);
    // Half of the way, beyond a dead zone of 0.15, on a curve of 2.
    player.axis(pad, GamepadAxis::LeftStickX, 0.5);
    player.frame();
    close(player.axis2_of::<Orbit>().x, 120.0 * FRAME * (0.35f32 / 0.85).powi(2));
    player.disconnect(pad);
    player.frame();
    assert!(!player.held::<NextMaterial>() && !player.held::<Orbit>());
}

#[test]
fn a_shoulder_makes_another_layer() {
    let mut player = Player::new();
    let pad = player.connect("Test pad");
    player.button(pad, GamepadButton::LeftTrigger, 1.0);
    player.frame();
    player.button(pad, GamepadButton::East, 1.0);
    player.axis(pad, GamepadAxis::LeftStickY, 1.0);
    player.frame();
    assert!(player.started::<NextEnvironment>() && !player.held::<NextMaterial>());
    close(player.axis2_of::<Walk>().y, 2.0 * FRAME);
    assert!(!player.held::<Orbit>());
    // The shoulder first: the other layer's actions don't begin with what is still held.
    player.button(pad, GamepadButton::LeftTrigger, 0.0);
    player.frames(2);
    assert!(!player.held::<NextEnvironment>() && !player.held::<NextMaterial>());
    assert!(!player.held::<Walk>() && !player.held::<Orbit>());
}

#[test]
fn triggers_are_buttons_that_do_not_tremble() {
    let mut player = Player::new();
    let pad = player.connect("Test pad");
    player.button(pad, GamepadButton::RightTrigger, 1.0);
    let mut begun = 0;
    for value in [0.3, 0.49, 0.51, 0.47, 0.52, 0.45, 0.55, 0.3, 0.0] {
        player.button(pad, GamepadButton::RightTrigger2, value);
        player.frame();
        begun += u32::from(player.started::<Brighter>());
    }
    assert_eq!(begun, 1);
}

#[test]
fn what_begins_on_a_panel_never_reaches_the_scene() {
    let mut player = Player::new();
    let capture = |player: &mut Player, pointer| {
        player.app.insert_resource(InputCapture { pointer, ..default() });
    };
    player.mouse(MouseButton::Left, true);
    player.move_mouse(4.0, 0.0);
    player.frame();
    assert!(player.held::<Orbit>());
    // It began on the scene, and goes on over a panel; the wheel is the panel's.
    capture(&mut player, true);
    player.move_mouse(4.0, 0.0);
    player.scroll(MouseScrollUnit::Line, 1.0);
    player.frame();
    assert!(player.held::<Orbit>() && !player.held::<Zoom>());
    player.mouse(MouseButton::Left, false);
    player.frame();
    player.mouse(MouseButton::Left, true);
    player.move_mouse(4.0, 0.0);
    player.frame();
    assert!(!player.held::<Orbit>());
    capture(&mut player, false);
    player.move_mouse(4.0, 0.0);
    player.frame();
    assert!(!player.held::<Orbit>());
}

#[test]
fn texts_take_letters_and_leave_function_keys() {
    let mut player = Player::new();
    player.key(KeyCode::KeyW, true);
    player.frame();
    assert!(player.held::<Walk>());
    player.app.insert_resource(InputCapture { keyboard: true, ..default() });
    player.key(KeyCode::KeyM, true);
    player.key(KeyCode::F1, true);
    player.frame();
    assert!(!player.held::<Walk>() && !player.held::<Menu>() && player.started::<Help>());
    // Nothing begins because the text ends.
    player.app.insert_resource(InputCapture::default());
    player.frame();
    assert!(!player.held::<Walk>() && !player.held::<Menu>());
}

#[test]
fn an_open_panel_takes_its_inputs() {
    let mut player = Player::new();
    player.app.insert_resource(InputCapture { panel: true, ..default() });
    player.key(KeyCode::ArrowRight, true);
    player.frame();
    assert!(player.started::<PanelMore>() && !player.held::<NextMaterial>());
    player.key(KeyCode::ArrowRight, false);
    player.key(KeyCode::Escape, true);
    player.frame();
    assert!(player.started::<PanelBack>() && !player.held::<Quit>());
    // Esc closes the panel, and doesn't quit because it is still down.
    player.app.insert_resource(InputCapture::default());
    player.frames(2);
    assert!(!player.held::<Quit>() && !player.held::<PanelBack>());
    player.key(KeyCode::Escape, false);
    player.frame();
    player.key(KeyCode::Escape, true);
    player.frame();
    assert!(player.started::<Quit>());
}
