//! A camera that walks: W A S D Q E move, mouse drag or arrow keys look around.

use bevy::{input::mouse::AccumulatedMouseMotion, prelude::*};

/// Where the camera looks.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Walker {
    yaw: f32,
    pitch: f32,
}

impl From<&Transform> for Walker {
    fn from(transform: &Transform) -> Self {
        let (yaw, pitch, _) = transform.rotation.to_euler(EulerRot::YXZ);
        Self { yaw, pitch }
    }
}

/// Radians a pixel of mouse motion.
const DRAG: f32 = 0.004;
/// Radians a second of an arrow key.
const TURN: f32 = 1.2;
/// Metres a second.
const SPEED: f32 = 1.6;

/// Turns and moves the camera.
pub fn walk(
    time: Res<Time>,
    keys: Res<ButtonInput<KeyCode>>,
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    mut cameras: Query<(&mut Walker, &mut Transform)>,
) {
    let axis = |more, less| {
        f32::from(u8::from(keys.pressed(more))) - f32::from(u8::from(keys.pressed(less)))
    };
    let mut turn = Vec2::new(
        axis(KeyCode::ArrowLeft, KeyCode::ArrowRight),
        axis(KeyCode::ArrowUp, KeyCode::ArrowDown),
    ) * TURN
        * time.delta_secs();
    if buttons.pressed(MouseButton::Left) {
        turn -= motion.delta * DRAG;
    }
    let step = Vec3::new(
        axis(KeyCode::KeyD, KeyCode::KeyA),
        axis(KeyCode::KeyE, KeyCode::KeyQ),
        axis(KeyCode::KeyS, KeyCode::KeyW),
    );
    if turn == Vec2::ZERO && step == Vec3::ZERO {
        return;
    }
    for (mut walker, mut transform) in &mut cameras {
        walker.yaw += turn.x;
        walker.pitch = (walker.pitch + turn.y).clamp(-1.5, 1.5);
        transform.rotation = Quat::from_euler(EulerRot::YXZ, walker.yaw, walker.pitch, 0.0);
        let way = Quat::from_rotation_y(walker.yaw) * step.normalize_or_zero();
        transform.translation += way * SPEED * time.delta_secs();
    }
}
