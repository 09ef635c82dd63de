//! A camera that never rests: a head that looks at something.

use bevy::prelude::*;

use super::{orbit::Orbit, shown::Shown};

/// Moves the camera about its place: some centimetres and parts of a degree, as people do who stand.
pub fn sway(
    time: Res<Time>,
    shown: Res<Shown>,
    mut cameras: Query<(&Orbit, &mut Transform)>,
    mut swayed: Local<bool>,
) {
    if !shown.sway && !*swayed {
        return;
    }
    *swayed = shown.sway;
    for (orbit, mut transform) in &mut cameras {
        let still = orbit.transform();
        *transform = if shown.sway { still * offset(time.elapsed_secs()) } else { still };
    }
}

/// The head's motion in its own frame; periods that never fall together.
fn offset(seconds: f32) -> Transform {
    let wave = |hertz: f32, phase: f32| (std::f32::consts::TAU * hertz * seconds + phase).sin();
    let place = Vec3::new(
        0.012 * wave(0.31, 0.0) + 0.004 * wave(0.83, 1.0),
        0.006 * wave(0.47, 2.0),
        0.010 * wave(0.23, 0.5),
    );
    let turn = Quat::from_euler(
        EulerRot::YXZ,
        0.006 * wave(0.37, 1.5),
        0.004 * wave(0.53, 0.7),
        0.003 * wave(0.29, 2.2),
    );
    Transform::from_translation(place).with_rotation(turn)
}
