//! Eyes, head and hands follow what the headset says, and stand where the rig stands.

use bevy::{math::Vec3A, prelude::*};
use farlight::{
    controls::{
        XrControllers,
        bindings::{Hand, Profile, Xr},
    },
    xr::{Recentre, XrHandPose, XrHandTracking, XrHead, XrPlugin, XrRig, XrTracking, eye_camera},
};

use crate::stage::views;

/// An app that draws nothing.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, XrPlugin::default()));
    app
}

fn place(app: &App, entity: Entity) -> Vec3 {
    app.world().get::<GlobalTransform>(entity).unwrap().translation()
}

const HEAD: Isometry3d =
    Isometry3d { rotation: Quat::IDENTITY, translation: Vec3A::new(0.5, 1.7, 0.2) };

#[test]
fn the_head_is_between_the_eyes_wherever_the_rig_stands() {
    let mut app = app();
    let head = app.world_mut().spawn(XrHead).id();
    let eyes = [0, 1].map(|index| app.world_mut().spawn(eye_camera(index, 0.05)).id());
    app.world_mut().resource_mut::<XrTracking>().eyes = Some(views(HEAD));
    app.update();
    assert!(place(&app, head).abs_diff_eq(Vec3::new(0.5, 1.7, 0.2), 1e-5));

    let in_rig = app.world().get::<Transform>(head).unwrap().translation;
    let mut rig = app.world_mut().resource_mut::<XrRig>();
    rig.set_scale(in_rig, 2.0);
    rig.turn(in_rig, 90.0);
    rig.teleport_to(in_rig, Vec3::new(10.0, 1.0, -5.0));
    app.update();
    let there = place(&app, head);
    assert!(there.abs_diff_eq(Vec3::new(10.0, 1.0 + 3.4, -5.0), 1e-4), "{there}");
    // A larger person's eyes are farther apart; after a turn to the right, along z.
    let [left, right] = eyes.map(|eye| place(&app, eye));
    assert!((right - left).abs_diff_eq(Vec3::Z * 2.0 * 0.063, 1e-4), "{}", right - left);
    let forward = app.world().get::<GlobalTransform>(head).unwrap().forward();
    assert!(forward.abs_diff_eq(Vec3::X, 1e-4), "{forward:?}");
}

#[test]
fn who_is_put_back_stands_in_the_rigs_middle() {
    let mut app = app();
    let head = app.world_mut().spawn(XrHead).id();
    let hand = XrHandPose { hand: Hand::Left, aim: true };
    let hand = app.world_mut().spawn(hand).id();
    let turned = Isometry3d::new(HEAD.translation, Quat::from_rotation_y(1.0));
    let mut tracking = app.world_mut().resource_mut::<XrTracking>();
    tracking.eyes = Some(views(turned));
    // Half a metre before the eyes.
    let aim = turned * Isometry3d::from_translation(Vec3::NEG_Z * 0.5);
    tracking.hand_mut(Hand::Left).aim = Some(aim);
    app.world_mut().resource_mut::<XrRig>().0.translation = Vec3::new(7.0, 0.0, 0.0);
    app.world_mut().write_message(Recentre);
    app.update();
    app.update();
    assert!(place(&app, head).abs_diff_eq(Vec3::new(7.0, 1.7, 0.0), 1e-4));
    assert!(place(&app, hand).abs_diff_eq(Vec3::new(7.0, 1.7, -0.5), 1e-4));
    // Again: nothing changes.
    app.world_mut().write_message(Recentre);
    app.update();
    assert!(place(&app, head).abs_diff_eq(Vec3::new(7.0, 1.7, 0.0), 1e-4));
}

#[test]
fn hands_are_there_before_the_frame_asks_and_hide_when_lost() {
    #[derive(Resource, Default)]
    struct Asked(Vec<Vec3>);
    let mut app = app();
    app.init_resource::<Asked>().add_systems(
        Update,
        |hand: Single<&GlobalTransform, With<XrHandPose>>, mut asked: ResMut<Asked>| {
            asked.0.push(hand.translation());
        },
    );
    let hand = app.world_mut().spawn(XrHandPose { hand: Hand::Right, aim: false }).id();
    app.update();
    assert_eq!(app.world().get::<Visibility>(hand), Some(&Visibility::Hidden));
    let grip = Some(Isometry3d::from_translation(Vec3::new(0.2, 1.2, -0.3)));
    *app.world_mut().resource_mut::<XrTracking>().hand_mut(Hand::Right) =
        XrHandTracking { grip, aim: None };
    app.world_mut().resource_mut::<XrRig>().0.translation.x = 1.0;
    app.update();
    assert_eq!(app.world().get::<Visibility>(hand), Some(&Visibility::Inherited));
    let asked = *app.world().resource::<Asked>().0.last().unwrap();
    assert!(asked.abs_diff_eq(Vec3::new(1.2, 1.2, -0.3), 1e-5), "in the same frame: {asked}");
    app.world_mut().resource_mut::<XrTracking>().hand_mut(Hand::Right).grip = None;
    app.update();
    assert_eq!(app.world().get::<Visibility>(hand), Some(&Visibility::Hidden));
}

#[test]
fn a_hand_that_turns_swings() {
    let mut app = app();
    let mut swings = Vec::new();
    for frame in 0..3 {
        app.world_mut().resource_mut::<XrControllers>().hand_mut(Hand::Right).profile =
            Some(Profile::Simple);
        let turn = Quat::from_rotation_y(-(5.0 * frame as f32).to_radians());
        app.world_mut().resource_mut::<XrTracking>().hand_mut(Hand::Right).aim =
            Some(Isometry3d::from_rotation(turn));
        app.update();
        swings.push(app.world().resource::<XrControllers>().value(Hand::Right, Xr::Swing));
    }
    // Where the hand was before it was seen, nobody knows.
    assert_eq!(swings[0], Vec2::ZERO);
    assert!(swings[1].abs_diff_eq(Vec2::new(5.0, 0.0), 1e-3), "{:?}", swings[1]);
    assert!(swings[2].abs_diff_eq(Vec2::new(5.0, 0.0), 1e-3), "{:?}", swings[2]);
    app.update();
    assert_eq!(app.world().resource::<XrControllers>().value(Hand::Right, Xr::Swing), Vec2::ZERO);
    app.world_mut().resource_mut::<XrTracking>().hand_mut(Hand::Right).aim = None;
    app.update();
    assert_eq!(app.world().resource::<XrControllers>().value(Hand::Right, Xr::Swing), Vec2::ZERO);
}
