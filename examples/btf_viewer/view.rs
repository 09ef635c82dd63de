//! Looking round: actions move the desktop's camera, or the person's room in a headset.

use bevy::prelude::*;
use farlight::{
    prelude::*,
    xr::{Recentre, XrHead, XrRig, XrStatus},
};

use super::{actions::Said, config::Viewer, stage::Stage, state::Config, viewpoint::Viewpoint};

/// Puts cameras and room back to where they began.
#[derive(Message, Clone, Copy, Debug, Default)]
pub struct ResetView;

/// Degrees of a turn by a step.
const STEP: f32 = 30.0;

/// Where the configuration wants the desktop's camera.
pub fn start(config: &Viewer, stage: &Stage) -> Viewpoint {
    Viewpoint::new(stage.middle + Vec3::from(config.camera.position), stage.middle)
}

/// Moves the desktop's camera.
pub fn look(
    controls: Controls,
    stage: Res<Stage>,
    mut cameras: Query<(&mut Viewpoint, &mut Transform)>,
) {
    let (orbit, pan) = (controls.axis2::<actions::Orbit>(), controls.axis2::<actions::Pan>());
    let zoom = controls.axis::<actions::Zoom>();
    let (walk, rise) = (controls.axis2::<actions::Walk>(), controls.axis::<actions::Rise>());
    for (mut viewpoint, mut transform) in &mut cameras {
        let mut new = *viewpoint;
        if orbit != Vec2::ZERO {
            new.orbit(orbit);
        }
        if pan != Vec2::ZERO {
            new.pan(pan);
        }
        if zoom != 0.0 {
            new.zoom(zoom);
        }
        if walk != Vec2::ZERO || rise != 0.0 {
            new.walk(walk, rise, stage.middle);
        }
        // What moves isn't refined.
        if viewpoint.set_if_neq(new) {
            transform.set_if_neq(new.transform());
        }
    }
}

/// Puts everything back.
pub fn reset(
    controls: Controls,
    mut resets: MessageReader<ResetView>,
    config: Res<Config>,
    stage: Res<Stage>,
    status: Res<XrStatus>,
    mut rig: ResMut<XrRig>,
    mut recentre: MessageWriter<Recentre>,
    mut cameras: Query<(&mut Viewpoint, &mut Transform)>,
    mut said: Said,
) {
    let recentred = controls.started::<actions::Recentre>();
    if recentred {
        said.say("View recentred");
    }
    let changed = stage.is_changed() && !stage.is_added();
    if resets.read().count() == 0 && !recentred && !changed {
        return;
    }
    for (mut viewpoint, mut transform) in &mut cameras {
        *viewpoint = start(&config.0, &stage);
        *transform = viewpoint.transform();
    }
    *rig = XrRig::default();
    if *status == XrStatus::Running && !changed {
        recentre.write(Recentre);
    }
}

/// Moves the room of who wears a headset, so that it looks as if the camera moved in the same way.
pub fn move_room(
    controls: Controls,
    stage: Res<Stage>,
    status: Res<XrStatus>,
    mut rig: ResMut<XrRig>,
    heads: Query<&Transform, With<XrHead>>,
) {
    if *status != XrStatus::Running {
        return;
    }
    let head = heads.iter().next().copied().unwrap_or(Transform::from_xyz(0.0, 1.6, 0.0));
    let mut new = rig.0;
    let orbit = controls.axis2::<actions::Orbit>();
    if orbit.x != 0.0 {
        new.rotate_around(stage.middle, Quat::from_rotation_y(-orbit.x.to_radians()));
    }
    let step = i8::from(controls.started::<actions::TurnLeft>())
        - i8::from(controls.started::<actions::TurnRight>());
    if step != 0 {
        let mut turned = XrRig(new);
        turned.turn(head.translation, -f32::from(step) * STEP);
        new = turned.0;
    }
    let eye = new.transform_point(head.translation);
    let level = level(new.rotation * head.rotation);
    let walk = controls.axis2::<actions::Walk>();
    new.translation += level * Vec3::new(walk.x, 0.0, -walk.y);
    // Up and down too, as a camera that goes round over the top: the horizon stays level.
    new.translation.y += controls.axis::<actions::Rise>();
    let zoom = controls.axis::<actions::Zoom>();
    if zoom != 0.0 {
        let away = (eye - stage.middle).with_y(0.0);
        let distance = (away.length() * 0.9_f32.powf(zoom)).clamp(0.15, 10.0);
        new.translation += away.normalize_or(Vec3::Z) * distance - away;
    }
    new.translation = new.translation.clamp_length_max(100.0);
    rig.set_if_neq(XrRig(new));
}

/// A head's turn about the vertical axis.
fn level(rotation: Quat) -> Quat {
    let ahead = rotation * Vec3::NEG_Z;
    Quat::from_rotation_y((-ahead.x).atan2(-ahead.z))
}
