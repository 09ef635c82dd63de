//! Controllers of a headset, fed by hand.

use bevy::prelude::*;
use farlight::controls::{InputCapture, actions::*};
use farlight_bindings::{Hand, Profile, Xr};

use crate::player::{FRAME, Player};

#[test]
fn controllers_act_within_a_frame_and_let_go_when_they_leave() {
    let mut player = Player::new();
    player.hold(Profile::Touch);
    player.hand(Hand::Right, Xr::Primary, 1.0, 0.0);
    player.hand(Hand::Left, Xr::Stick, 0.0, 1.0);
    player.frame();
    assert!(player.started::<NextMaterial>());
    assert!((player.axis2_of::<Orbit>().y - 90.0 * FRAME).abs() < 1e-4);
    player.app.insert_resource(farlight::controls::XrControllers::default());
    player.frame();
    assert!(!player.held::<NextMaterial>() && !player.held::<Orbit>());
}

#[test]
fn a_trigger_that_is_held_makes_a_layer() {
    let mut player = Player::new();
    player.hold(Profile::Touch);
    player.hand(Hand::Left, Xr::Trigger, 1.0, 0.0);
    player.hand(Hand::Left, Xr::Stick, 0.0, 1.0);
    player.frame();
    assert!(player.held::<Walk>() && !player.held::<Orbit>());
    player.hand(Hand::Right, Xr::Trigger, 1.0, 0.0);
    player.hand(Hand::Right, Xr::Stick, -1.0, 0.0);
    player.frame();
    assert!(player.started::<Evaluation1>());
}

#[test]
fn a_ray_on_a_panel_takes_the_trigger_of_its_hand() {
    let mut player = Player::new();
    player.hold(Profile::Touch);
    player.app.insert_resource(InputCapture { hands: [false, true], ..default() });
    player.hand(Hand::Right, Xr::Trigger, 1.0, 0.0);
    player.hand(Hand::Right, Xr::Stick, 1.0, 0.0);
    player.frame();
    assert!(!player.held::<RotateEnvironment>() && player.held::<RotateObject>());
}

#[test]
fn other_controllers_have_other_bindings() {
    let mut player = Player::new();
    player.hold(Profile::Simple);
    player.hand(Hand::Left, Xr::Select, 1.0, 0.0);
    player.hand(Hand::Left, Xr::Swing, 3.0, -1.0);
    player.frame();
    assert_eq!(player.axis2_of::<Orbit>(), Vec2::new(6.0, -2.0));
    player.hold(Profile::Touch);
    player.frame();
    assert!(!player.held::<Orbit>());
}
