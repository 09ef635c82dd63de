//! Cameras and hands, as numbers.

use std::f32::consts::FRAC_PI_2;

use bevy::{math::Isometry3d, prelude::*};

use crate::{grab::Held, viewpoint::Viewpoint};

#[test]
fn both_kinds_of_camera_work_at_any_time() {
    let near = |a: Vec3, b: Vec3| assert!(a.abs_diff_eq(b, 1e-4), "{a} {b}");
    let middle = Vec3::new(0.2, 0.1, 0.0);
    let mut view = Viewpoint::new(Vec3::new(1.7, 0.8, 3.7), middle);
    near(view.eye(), Vec3::new(1.7, 0.8, 3.7));
    near(view.rotation() * Vec3::NEG_Z, (middle - view.eye()).normalize());
    // Round the object: its distance stays, and it stays in the middle.
    view.orbit(Vec2::new(50.0, -10.0));
    assert!((view.eye().distance(middle) - view.distance).abs() < 1e-4);
    // A step moves the eye by as much and turns nothing.
    let (eye, rotation) = (view.eye(), view.rotation());
    view.walk(Vec2::new(0.5, 1.0), 0.25, middle);
    assert!((view.eye().distance(eye) - Vec3::new(0.5, 0.25, 1.0).length()).abs() < 1e-4);
    assert!(view.rotation().abs_diff_eq(rotation, 1e-6));
    // Then it goes round a point ahead as far as the object is: neither eye nor picture jumps.
    let (eye, target) = (view.eye(), view.target);
    view.orbit(Vec2::ZERO);
    near(view.eye(), eye);
    view.orbit(Vec2::new(30.0, 0.0));
    near(view.target, target);
    assert!((target - middle).length() < 1.5, "{target}");
    // Behind the back there is nothing to go round: it looks about from where it is.
    view.walk(Vec2::new(0.0, 20.0), 0.0, middle);
    let eye = view.eye();
    view.orbit(Vec2::new(90.0, 0.0));
    assert!(view.eye().distance(eye) < 0.5);
    // Closer is a tenth of the distance; pans are parts of it, and what is seen follows.
    let mut view = Viewpoint::new(Vec3::Z * 2.0, Vec3::ZERO);
    view.zoom(1.0);
    near(view.eye(), Vec3::Z * 1.8);
    view.pan(Vec2::new(100.0, 0.0));
    near(view.eye(), Vec3::new(-0.18, 0.0, 1.8));
    // Whatever is done, it stays a camera.
    for _ in 0..200 {
        view.walk(Vec2::new(10.0, -10.0), -10.0, Vec3::ZERO);
        view.zoom(-5.0);
        view.orbit(Vec2::new(0.0, -77.0));
    }
    assert!(view.eye().is_finite() && view.eye().length() < 200.0 && view.pitch < 1.6);
}

#[test]
fn hands_hold_the_object() {
    let near = |a: Vec3, b: Vec3| assert!(a.abs_diff_eq(b, 1e-4), "{a} {b}");
    let hand = |place: Vec3, turn: f32| Isometry3d::new(place, Quat::from_rotation_y(turn));
    let object = Held { place: Vec3::new(0.1, 1.2, -0.5), rotation: Quat::IDENTITY, scale: 1.0 };
    // One hand that is at it: a quarter turn about the hand.
    let at = Vec3::new(0.0, 1.2, -0.5);
    let turned = object.by_one(hand(at, 0.0), hand(at, FRAC_PI_2), 0.3);
    near(turned.place, Vec3::new(0.0, 1.2, -0.6));
    near(turned.rotation * Vec3::X, Vec3::NEG_Z);
    // From afar: about its own middle, and it moves as the hand does.
    let far = Vec3::new(0.3, 1.0, 0.5);
    let moved = object.by_one(hand(far, 0.0), hand(far + Vec3::X * 0.1, FRAC_PI_2), 0.3);
    near(moved.place, object.place + Vec3::X * 0.1);
    near(moved.rotation * Vec3::X, Vec3::NEG_Z);
    // Both hands: apart is larger, about the middle between them.
    let pair =
        |half: Vec3, turn: f32| [hand(object.place - half, turn), hand(object.place + half, turn)];
    let scales = [0.05, 20.0];
    let grown = object.by_both(pair(Vec3::X * 0.1, 0.0), pair(Vec3::X * 0.25, 0.0), scales);
    assert!((grown.scale - 2.5).abs() < 1e-4);
    near(grown.place, object.place);
    assert!(grown.rotation.abs_diff_eq(Quat::IDENTITY, 1e-4));
    // The line between them turned: so did the object. Hands that turn along with it count once.
    for turn in [0.0, FRAC_PI_2] {
        let steered =
            object.by_both(pair(Vec3::X * 0.2, 0.0), pair(Vec3::NEG_Z * 0.2, turn), scales);
        near(steered.rotation * Vec3::X, Vec3::NEG_Z);
        near(steered.rotation * Vec3::Y, Vec3::Y);
    }
    // Both wrists turned about that line.
    let wrists = pair(Vec3::X * 0.2, 0.0)
        .map(|hand| Isometry3d::new(hand.translation, Quat::from_rotation_x(0.5)));
    let rolled = object.by_both(pair(Vec3::X * 0.2, 0.0), wrists, scales);
    assert!(rolled.rotation.abs_diff_eq(Quat::from_rotation_x(0.5), 1e-4), "{rolled:?}");
    // Within bounds, and never senseless.
    let tiny = object.by_both(pair(Vec3::X, 0.0), pair(Vec3::X * 0.001, 0.0), scales);
    assert!(tiny.place.is_finite() && tiny.scale >= 0.05);
    let huge = object.by_both(pair(Vec3::X * 0.02, 0.0), pair(Vec3::X, 0.0), scales);
    assert_eq!(huge.scale, 20.0);
}
