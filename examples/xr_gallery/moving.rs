//! How people get about: on the desktop they walk and look; in a headset they teleport, turn by steps and
//! may walk.

use bevy::prelude::*;
use farlight::{
    controls::{
        Controls,
        actions::{
            Orbit, Recentre as RecentreAction, Reset, Teleport, TurnLeft, TurnRight, Walk, Zoom,
        },
        bindings::Hand,
    },
    xr::{DesktopCamera, Haptic, Recentre, XrHandPose, XrHead, XrRig, XrStatus},
};

use super::{
    looks::{EYES, FIELD},
    plan::{ENTRANCE, Floor},
    teleport::{self, Arc},
};

/// Degrees of a step to the side.
const TURN: f32 = 30.0;

/// Who looks without a headset.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Visitor {
    /// Radians to the left; 0 looks to the north.
    pub yaw: f32,
    /// Radians upwards.
    pub pitch: f32,
}

impl Visitor {
    /// Looking like that from a place.
    pub fn transform(&self, eyes: Vec3) -> Transform {
        Transform::from_translation(eyes).with_rotation(Quat::from_euler(
            EulerRot::YXZ,
            self.yaw,
            self.pitch,
            0.0,
        ))
    }
}

/// Where the left hand aims to go, while it does.
#[derive(Resource, Clone, Debug, Default)]
pub struct Aiming(pub Option<Arc>);

/// Systems of getting about.
pub fn plugin(app: &mut App) {
    app.init_resource::<Aiming>()
        .insert_resource(XrRig(Transform::from_translation(ENTRANCE)))
        .add_systems(Update, (look_and_walk, teleport, turn_and_walk_in_headset, put_back));
}

fn look_and_walk(
    controls: Controls,
    floor: Res<Floor>,
    mut visitors: Query<
        (&mut Visitor, &mut Transform, &mut Projection, &Camera),
        With<DesktopCamera>,
    >,
) {
    let (look, walk) = (controls.axis2::<Orbit>(), controls.axis2::<Walk>());
    let zoom = controls.axis::<Zoom>();
    if look == Vec2::ZERO && walk == Vec2::ZERO && zoom == 0.0 {
        return;
    }
    for (mut visitor, mut transform, mut projection, camera) in &mut visitors {
        if !camera.is_active {
            continue;
        }
        visitor.yaw -= look.x.to_radians();
        visitor.pitch = (visitor.pitch + look.y.to_radians()).clamp(-1.5, 1.5);
        let feet = transform.translation.with_y(0.0);
        let step = Quat::from_rotation_y(visitor.yaw) * Vec3::new(walk.x, 0.0, -walk.y);
        *transform = visitor.transform(floor.walk(feet, step) + Vec3::Y * EYES);
        if let (Projection::Perspective(lens), true) = (&mut *projection, zoom != 0.0) {
            lens.fov = (lens.fov * 0.9_f32.powf(zoom)).clamp(0.25, FIELD.to_radians() * 1.2);
        }
    }
}

/// Hold, aim, let go.
fn teleport(
    controls: Controls,
    floor: Res<Floor>,
    hands: Query<(&XrHandPose, &GlobalTransform)>,
    heads: Query<&Transform, With<XrHead>>,
    mut rig: ResMut<XrRig>,
    mut aiming: ResMut<Aiming>,
    mut haptics: MessageWriter<Haptic>,
) {
    let held = controls.held::<Teleport>();
    if held {
        let hand = hands.iter().find(|(pose, _)| pose.hand == Hand::Left && pose.aim);
        let Some((_, aim)) = hand else { return };
        let arc = teleport::throw(aim.translation(), aim.forward().into(), &floor);
        let lands = |arc: Option<&Arc>| arc.is_some_and(|arc| arc.landing.is_some());
        if lands(Some(&arc)) && !lands(aiming.0.as_ref()) {
            haptics.write(Haptic::tick(Hand::Left));
        }
        aiming.0 = Some(arc);
        return;
    }
    let Some(arc) = aiming.bypass_change_detection().0.take() else { return };
    aiming.set_changed();
    if let (Some(landing), Some(head)) = (arc.landing, heads.iter().next()) {
        rig.teleport_to(head.translation, landing);
        haptics.write(Haptic { hand: Hand::Left, amplitude: 0.6, seconds: 0.04 });
    }
}

fn turn_and_walk_in_headset(
    controls: Controls,
    floor: Res<Floor>,
    heads: Query<(&Transform, &GlobalTransform), With<XrHead>>,
    mut rig: ResMut<XrRig>,
) {
    let Some((head, in_world)) = heads.iter().next() else { return };
    let turns =
        i32::from(controls.started::<TurnRight>()) - i32::from(controls.started::<TurnLeft>());
    if turns != 0 {
        rig.turn(head.translation, TURN * turns as f32);
    }
    let walk = controls.axis2::<Walk>();
    if walk != Vec2::ZERO {
        let ahead = in_world.forward().with_y(0.0).normalize_or_zero();
        let step = ahead * walk.y + ahead.cross(Vec3::Y) * walk.x;
        let feet = in_world.translation().with_y(rig.0.translation.y);
        let arrived = floor.walk(feet, step);
        if arrived != feet {
            rig.0.translation += arrived - feet;
        }
    }
}

/// As at the start; and once a headset shows the gallery, its person stands at the entrance.
fn put_back(
    controls: Controls,
    status: Option<Res<XrStatus>>,
    mut rig: ResMut<XrRig>,
    mut recentre: MessageWriter<Recentre>,
    mut visitors: Query<(&mut Visitor, &mut Transform)>,
) {
    let begins = status.is_some_and(|status| status.is_changed() && *status == XrStatus::Running);
    let reset = controls.started::<Reset>();
    if begins || reset || controls.started::<RecentreAction>() {
        recentre.write(Recentre);
    }
    if begins || reset {
        rig.0 = Transform::from_translation(ENTRANCE);
    }
    if reset {
        for (mut visitor, mut transform) in &mut visitors {
            *visitor = Visitor { yaw: 0.0, pitch: -0.06 };
            *transform = visitor.transform(ENTRANCE + Vec3::Y * EYES);
        }
    }
}
