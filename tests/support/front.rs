//! A camera in front of the origin that shows linear light as it is, and pixels to be asserted.

use bevy::{core_pipeline::tonemapping::Tonemapping, prelude::*};

use super::{
    headless::{Headless, Picture},
    linear,
};

/// A camera two metres in front of the origin that sees a square of two metres, with exposure 1.
pub fn camera() -> impl Bundle {
    (
        Camera3d::default(),
        Projection::from(OrthographicProjection {
            scaling_mode: bevy::camera::ScalingMode::Fixed { width: 2.0, height: 2.0 },
            ..OrthographicProjection::default_3d()
        }),
        Msaa::Off,
        Tonemapping::None,
        linear::exposure(),
        Transform::from_xyz(0.0, 0.0, 2.0),
    )
}

/// Asserts a pixel's colour, given as linear light that leaves the surface.
pub fn assert_pixel(headless: &Headless, picture: &Picture, x: u32, y: u32, expected: Vec3) {
    let encoded = Srgba::from(LinearRgba::rgb(expected.x, expected.y, expected.z));
    let expected = [encoded.red, encoded.green, encoded.blue]
        .map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8);
    let found = picture.pixels[(y * picture.width + x) as usize];
    let close = expected.iter().zip(found).all(|(e, f)| e.abs_diff(f) <= 2);
    assert!(close, "pixel {x}, {y} is {found:?}, not {expected:?} ({})", headless.adapter());
}
