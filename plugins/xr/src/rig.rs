//! Where the person's room stands in the world.

use bevy::prelude::*;

/// Scales that a person may have.
const SCALES: std::ops::RangeInclusive<f32> = 0.001..=1000.0;

/// The room of the person in the world: its floor's middle, turn and scale. A scale of 2 makes the
/// person twice as large, and the world half.
///
/// Head and hands move in it; what is done to it should leave the head where the person feels it, so
/// its methods take where the head is in the rig: the `Transform::translation` of
/// [`XrHead`](crate::XrHead).
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct XrRig(pub Transform);

/// Puts the person back: to the rig's middle, looking along its -z.
#[derive(Message, Clone, Copy, Debug, Default)]
pub struct Recentre;

/// The entity that stands where [`XrRig`] says; eyes, head and hands are its children.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(Transform, Visibility)]
pub struct XrRoot;

impl XrRig {
    /// Puts the person's feet to a place of the world; they look where they looked.
    pub fn teleport_to(&mut self, head_in_rig: Vec3, floor: Vec3) {
        self.place(feet(head_in_rig), floor);
    }

    /// Turns the person about themselves, in degrees, to the right.
    pub fn turn(&mut self, head_in_rig: Vec3, degrees: f32) {
        let feet = feet(head_in_rig);
        let floor = self.0.transform_point(feet);
        self.0.rotation *= Quat::from_rotation_y(-degrees.to_radians());
        self.0.rotation = self.0.rotation.normalize();
        self.place(feet, floor);
    }

    /// Makes the person as large; they stand where they stood. From 0.001 to 1000.
    pub fn set_scale(&mut self, head_in_rig: Vec3, scale: f32) {
        if !scale.is_finite() {
            return;
        }
        let feet = feet(head_in_rig);
        let floor = self.0.transform_point(feet);
        self.0.scale = Vec3::splat(scale.clamp(*SCALES.start(), *SCALES.end()));
        self.place(feet, floor);
    }

    /// Moves the rig so that a place in it is at a place of the world.
    fn place(&mut self, in_rig: Vec3, in_world: Vec3) {
        if in_world.is_finite() && in_rig.is_finite() {
            self.0.translation = in_world - self.0.rotation * (self.0.scale * in_rig);
        }
    }
}

/// The floor below the head.
fn feet(head: Vec3) -> Vec3 {
    Vec3::new(head.x, 0.0, head.z)
}

/// From the headset's own space to the rig: where the person was when they last asked to be put
/// back, and how far the space's origin is above the floor if the headset doesn't know the floor.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Origin {
    pub(crate) rig_from_tracking: Isometry3d,
    /// Metres.
    pub(crate) lift: f32,
}

impl Origin {
    /// Where something of the headset's space is in the rig.
    pub(crate) fn to_rig(self, pose: Isometry3d) -> Isometry3d {
        let lift = Isometry3d::from_translation(Vec3::Y * self.lift);
        lift * self.rig_from_tracking * pose
    }

    /// Makes the head's place the middle, and where it looks the front.
    pub(crate) fn recentre(&mut self, head_in_tracking: Isometry3d) {
        let place: Vec3 = head_in_tracking.translation.into();
        if !place.is_finite() || !head_in_tracking.rotation.is_finite() {
            return;
        }
        let yaw = Quat::from_rotation_y(yaw(head_in_tracking.rotation));
        self.rig_from_tracking = Isometry3d::new(feet(place), yaw).inverse();
    }
}

/// How far somebody is turned to the left who looks like that, in radians; who looks straight up or
/// down is turned as the top of their head says.
fn yaw(look: Quat) -> f32 {
    let forward = look * Vec3::NEG_Z;
    let up = look * Vec3::Y;
    let front = if forward.xz().length() > 0.2 { forward } else { up * -forward.y.signum() };
    f32::atan2(-front.x, -front.z)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_PI_2, PI};

    use super::*;

    const HEAD: Vec3 = Vec3::new(0.4, 1.7, -0.6);

    fn rig() -> XrRig {
        XrRig(
            Transform::from_xyz(3.0, 1.0, 2.0)
                .with_rotation(Quat::from_rotation_y(0.7))
                .with_scale(Vec3::splat(1.5)),
        )
    }

    #[test]
    fn who_teleports_stands_there_and_looks_as_before() {
        let mut moved = rig();
        let floor = Vec3::new(-4.0, 0.25, 9.0);
        moved.teleport_to(HEAD, floor);
        let head = moved.0.transform_point(HEAD);
        assert!(head.abs_diff_eq(floor + Vec3::Y * 1.7 * 1.5, 1e-5), "{head}");
        assert_eq!(moved.0.rotation, rig().0.rotation);
        let before = moved;
        moved.teleport_to(HEAD, Vec3::NAN);
        assert_eq!(moved, before, "nowhere is no place");
    }

    #[test]
    fn who_turns_stays_in_place() {
        let mut turned = rig();
        let head = turned.0.transform_point(HEAD);
        let forward = turned.0.rotation * Vec3::NEG_Z;
        turned.turn(HEAD, 30.0);
        assert!(turned.0.transform_point(HEAD).abs_diff_eq(head, 1e-5));
        let now = turned.0.rotation * Vec3::NEG_Z;
        assert!((forward.dot(now) - 30_f32.to_radians().cos()).abs() < 1e-5);
        // To the right of the person, that is clockwise from above.
        assert!(forward.cross(now).y < 0.0);
        for _ in 0..11 {
            turned.turn(HEAD, 30.0);
        }
        assert!(turned.0.translation.abs_diff_eq(rig().0.translation, 1e-4), "a whole turn");
    }

    #[test]
    fn who_grows_stands_where_they_stood() {
        let mut large = rig();
        let feet_before = large.0.transform_point(feet(HEAD));
        large.set_scale(HEAD, 3.0);
        assert!(large.0.transform_point(feet(HEAD)).abs_diff_eq(feet_before, 1e-5));
        let head = large.0.transform_point(HEAD);
        assert!((head.y - feet_before.y - 1.7 * 3.0).abs() < 1e-5);
        large.set_scale(HEAD, f32::INFINITY);
        assert_eq!(large.0.scale, Vec3::splat(3.0));
    }

    #[test]
    fn who_is_put_back_is_in_the_middle_and_looks_ahead() {
        for (turn, nod) in
            [(0.5, 0.3), (-2.5, -0.8), (PI, 0.0), (1.0, FRAC_PI_2), (1.0, -FRAC_PI_2)]
        {
            let look = Quat::from_rotation_y(turn) * Quat::from_rotation_x(nod);
            let head = Isometry3d::new(HEAD, look);
            let mut origin = Origin { lift: 0.2, ..default() };
            origin.recentre(head);
            let there = origin.to_rig(head);
            let place: Vec3 = there.translation.into();
            assert!(place.abs_diff_eq(Vec3::Y * 1.9, 1e-5), "{place}");
            // What is left is the nod.
            let left = (there.rotation * Vec3::X).abs_diff_eq(Vec3::X, 1e-4);
            assert!(left, "turned {turn}, nodded {nod}: {:?}", there.rotation);
        }
    }
}
