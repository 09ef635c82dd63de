//! How far a hand's aim turned in a frame: what controllers without a stick can turn things with.

use std::f32::consts::{PI, TAU};

use bevy::prelude::*;
use farlight_bindings::{Hand, Xr};
use farlight_controls::XrControllers;

use crate::{XrSystems, XrTracking};

pub(crate) fn build(app: &mut App) {
    app.add_systems(PreUpdate, swing.in_set(XrSystems::Read).after(crate::tracking::follow_hands));
}

/// Writes it beside what is pressed.
fn swing(
    tracking: Res<XrTracking>,
    mut controllers: ResMut<XrControllers>,
    mut before: Local<[Option<Quat>; 2]>,
) {
    for hand in Hand::ALL {
        let aim = tracking.hand(hand).aim.map(|pose| pose.rotation);
        let last = std::mem::replace(&mut before[hand as usize], aim);
        let turned = match (last, aim, controllers.hand(hand).profile) {
            (Some(last), Some(aim), Some(_)) => turned(last, aim),
            _ => Vec2::ZERO,
        };
        if controllers.value(hand, Xr::Swing) != turned {
            controllers.hand_mut(hand).values.insert(Xr::Swing, turned);
        }
    }
}

/// Degrees to the right and up from one direction of aim to another, whatever the hand is rolled by.
fn turned(from: Quat, to: Quat) -> Vec2 {
    let angles = |look: Quat| {
        let forward = look * Vec3::NEG_Z;
        Vec2::new(f32::atan2(forward.x, -forward.z), forward.y.clamp(-1.0, 1.0).asin())
    };
    let (from, to) = (angles(from), angles(to));
    let right = (to.x - from.x + PI).rem_euclid(TAU) - PI;
    // Straight up and down every azimuth is the same direction.
    let along = ((to.y + from.y) / 2.0).cos();
    let turned = Vec2::new(right * along, to.y - from.y) * 180.0 / PI;
    if turned.is_finite() { turned } else { Vec2::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn aim(right: f32, up: f32, roll: f32) -> Quat {
        let [right, up, roll] = [right, up, roll].map(f32::to_radians);
        Quat::from_euler(EulerRot::YXZ, -right, up, roll)
    }

    #[test]
    fn a_turn_is_what_it_is_whatever_the_roll() {
        for roll in [0.0, 50.0, -170.0] {
            let degrees = turned(aim(175.0, 2.0, roll), aim(185.0, -2.0, roll / 2.0));
            assert!(degrees.abs_diff_eq(Vec2::new(10.0, -4.0), 0.02), "{degrees}");
        }
        let degrees = turned(aim(20.0, 89.9, 0.0), aim(130.0, 89.9, 0.0));
        assert!(degrees.length() < 0.3, "straight up: {degrees}");
    }
}
