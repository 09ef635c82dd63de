//! A touch screen.

use bevy::{input::touch::TouchPhase, prelude::*};
use farlight::controls::{ActiveDevice, InputCapture, actions::*};
use farlight_bindings::Device;

use crate::player::Player;

#[test]
fn fingers_act_within_a_frame() {
    let mut player = Player::new();
    player.finger(1, TouchPhase::Started, 100.0, 100.0);
    player.finger(1, TouchPhase::Moved, 140.0, 80.0);
    player.frame();
    assert_eq!(player.axis2_of::<Orbit>(), Vec2::new(10.0, 5.0));
    assert_eq!(player.app.world().resource::<ActiveDevice>().device, Device::Touch);
    player.finger(2, TouchPhase::Started, 240.0, 80.0);
    player.frame();
    assert!(!player.held::<Orbit>() && !player.held::<Zoom>());
    // Twice as far apart: half of the distance.
    player.finger(2, TouchPhase::Moved, 340.0, 80.0);
    player.frame();
    assert!((player.axis_of::<Zoom>() - 6.58).abs() < 1e-3);
    assert_eq!(player.axis2_of::<RotateObject>(), Vec2::new(12.5, 0.0));
    player.finger(2, TouchPhase::Ended, 340.0, 80.0);
    player.finger(1, TouchPhase::Canceled, 140.0, 80.0);
    player.frame();
    assert!(!player.held::<Menu>(), "a drag with two fingers is no tap");
    for id in [3, 4] {
        player.finger(id, TouchPhase::Started, 100.0 * id as f32, 80.0);
    }
    for id in [3, 4] {
        player.finger(id, TouchPhase::Ended, 100.0 * id as f32, 80.0);
    }
    player.frame();
    assert!(player.started::<Menu>());
    player.frame();
    assert!(player.ended::<Menu>());
}

#[test]
fn fingers_on_a_panel_and_lost_fingers_do_nothing() {
    let mut player = Player::new();
    player.app.insert_resource(InputCapture { pointer: true, ..default() });
    player.finger(1, TouchPhase::Started, 100.0, 100.0);
    player.frame();
    player.app.insert_resource(InputCapture::default());
    player.finger(1, TouchPhase::Moved, 300.0, 100.0);
    player.frame();
    assert!(!player.held::<Orbit>());
    player.finger(2, TouchPhase::Started, 100.0, 100.0);
    player.frame();
    player.lose_focus();
    player.frame();
    player.finger(2, TouchPhase::Moved, 300.0, 100.0);
    player.frame();
    assert!(!player.held::<Orbit>());
}
