//! The cameras of both eyes.

use bevy::prelude::*;

/// The camera of an eye.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct XrEye {
    /// 0 is left, 1 right.
    pub index: u32,
}

/// A field of view: angles in radians from the direction of view, to the right and up positive, each
/// between -pi/2 and pi/2. Eyes see farther outwards than inwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fov {
    /// Usually negative.
    pub left: f32,
    /// To the right.
    pub right: f32,
    /// Up.
    pub up: f32,
    /// Usually negative.
    pub down: f32,
}

/// Clip space from view space: reversed depth without a far plane, as Bevy's cameras have it.
/// `near` in metres.
pub fn eye_projection(fov: Fov, near: f32) -> Mat4 {
    let [left, right] = [fov.left.tan(), fov.right.tan()];
    let [down, up] = [fov.down.tan(), fov.up.tan()];
    let (width, height) = (right - left, up - down);
    Mat4::from_cols(
        Vec4::new(2.0 / width, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 2.0 / height, 0.0, 0.0),
        Vec4::new((right + left) / width, (up + down) / height, 0.0, -1.0),
        Vec4::new(0.0, 0.0, near, 0.0),
    )
}
