//! Where head and hands are.

use bevy::prelude::*;
use farlight_bindings::Hand;

/// An entity that follows the head: between the eyes, looking along -z. Its `Transform` is in the rig.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(Transform, Visibility)]
pub struct XrHead;

/// An entity that follows a hand; hidden while the hand isn't tracked. Its `Transform`, in the rig, and
/// its `GlobalTransform` are those of the frame from `PreUpdate` on.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Transform, Visibility)]
pub struct XrHandPose {
    /// Which.
    pub hand: Hand,
    /// Whether it points (along -z), or holds: OpenXR's aim and grip poses.
    pub aim: bool,
}

/// Shakes a controller.
#[derive(Message, Clone, Copy, Debug, PartialEq)]
pub struct Haptic {
    /// Which.
    pub hand: Hand,
    /// How hard, 0 to 1.
    pub amplitude: f32,
    /// For how long; 0 is as short as the controller can.
    pub seconds: f32,
}

impl Haptic {
    /// A short tick, as of a button that gives way.
    pub const fn tick(hand: Hand) -> Self {
        Self { hand, amplitude: 0.4, seconds: 0.0 }
    }
}
