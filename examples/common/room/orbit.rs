//! A camera that circles a point: mouse drag or arrow keys turn it, the wheel or page keys come closer.

use bevy::{
    input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll, MouseScrollUnit},
    prelude::*,
};

/// Where the camera looks and from where.
#[derive(Component, Clone, Copy, Debug)]
pub struct Orbit {
    /// The point that it looks at.
    pub target: Vec3,
    /// Metres from it.
    pub distance: f32,
    /// Turn around the vertical axis in radians; 0 looks along -z.
    pub yaw: f32,
    /// Height angle in radians; positive looks down.
    pub pitch: f32,
}

impl Orbit {
    /// The camera's place.
    pub fn transform(&self) -> Transform {
        let rotation = Quat::from_euler(EulerRot::YXZ, self.yaw, -self.pitch, 0.0);
        Transform::from_translation(self.target + rotation * Vec3::Z * self.distance)
            .with_rotation(rotation)
    }
}

/// Radians a pixel of mouse motion.
const DRAG: f32 = 0.005;
/// Radians a second of an arrow key.
const TURN: f32 = 1.2;
/// Factor of distance a line of the wheel.
const ZOOM: f32 = 0.9;
/// Pixels of a touch pad that count as one line of a wheel.
const PIXELS_A_LINE: f32 = 40.0;

/// Turns and moves the camera.
pub fn orbit(
    time: Res<Time>,
    keys: Res<ButtonInput<KeyCode>>,
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    scroll: Res<AccumulatedMouseScroll>,
    mut cameras: Query<(&mut Orbit, &mut Transform)>,
) {
    let pressed = |key| f32::from(u8::from(keys.pressed(key)));
    let mut turn = Vec2::new(
        pressed(KeyCode::ArrowLeft) - pressed(KeyCode::ArrowRight),
        pressed(KeyCode::ArrowUp) - pressed(KeyCode::ArrowDown),
    ) * TURN
        * time.delta_secs();
    if buttons.pressed(MouseButton::Left) {
        turn += Vec2::new(-motion.delta.x, motion.delta.y) * DRAG;
    }
    let lines =
        match scroll.unit {
            MouseScrollUnit::Line => scroll.delta.y,
            MouseScrollUnit::Pixel => scroll.delta.y / PIXELS_A_LINE,
        } + (pressed(KeyCode::PageUp) - pressed(KeyCode::PageDown)) * time.delta_secs() * 10.0;
    if turn == Vec2::ZERO && lines == 0.0 {
        return;
    }
    for (mut orbit, mut transform) in &mut cameras {
        orbit.yaw += turn.x;
        orbit.pitch = (orbit.pitch + turn.y).clamp(-1.5, 1.5);
        orbit.distance = (orbit.distance * ZOOM.powf(lines)).clamp(0.2, 30.0);
        *transform = orbit.transform();
    }
}
