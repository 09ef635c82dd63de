//! The device in hand.

use bevy::{input::mouse::MouseScrollUnit, prelude::*};
use farlight::controls::ActiveDevice;
use farlight_bindings::{Device, Hand, Profile, Xr};

use crate::player::Player;

fn in_hand(player: &Player) -> (Device, Option<&str>) {
    let active = player.app.world().resource::<ActiveDevice>();
    (active.device, active.name.as_deref())
}

#[test]
fn the_device_in_hand_is_the_one_that_is_used() {
    let mut player = Player::new();
    let pad = player.connect("Test pad");
    player.axis(pad, GamepadAxis::LeftStickX, 0.12);
    player.frames(3);
    assert_eq!(in_hand(&player), (Device::KeyboardMouse, None), "stick noise is no use");
    player.axis(pad, GamepadAxis::LeftStickX, 0.9);
    player.frame();
    assert_eq!(in_hand(&player), (Device::Gamepad, Some("Test pad")));
    for _ in 0..60 {
        player.move_mouse(0.5, 0.0);
        player.frame();
    }
    assert_eq!(in_hand(&player), (Device::Gamepad, Some("Test pad")), "a mouse trembles");
    player.scroll(MouseScrollUnit::Line, 1.0);
    player.frame();
    assert_eq!(in_hand(&player), (Device::KeyboardMouse, None));
    player.hold(Profile::Index);
    player.frame();
    assert_eq!(in_hand(&player).0, Device::KeyboardMouse, "controllers lie there");
    player.hand(Hand::Left, Xr::Primary, 1.0, 0.0);
    player.frame();
    assert_eq!(in_hand(&player).0, Device::Xr(Profile::Index));
    player.hand(Hand::Left, Xr::Primary, 0.0, 0.0);
    player.button(pad, GamepadButton::South, 1.0);
    player.frame();
    assert_eq!(in_hand(&player), (Device::Gamepad, Some("Test pad")));
    player.disconnect(pad);
    player.frame();
    assert_eq!(in_hand(&player), (Device::KeyboardMouse, None));
}
