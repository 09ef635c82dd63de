//! Hands in a headset: grips take hold of the object, the left one points at where to go.

use bevy::prelude::*;
use farlight::{
    controls::bindings::Hand,
    prelude::*,
    xr::{Haptic, XrHandPose, XrHead, XrRig, XrStatus},
};

use super::{
    grab::Held,
    object::Form,
    shown::{LEAST_SCALE, MOST_SCALE, Shown},
    stage::Stage,
};

/// How much farther than its own size the object is taken hold of as if the hand touched it.
const REACH: f32 = 1.4;
/// Metres that one can go at once.
const FAR: f32 = 8.0;

/// Moves, turns and scales the object with the hands that hold it.
pub fn grab(
    controls: Controls,
    stage: Res<Stage>,
    form: Res<Form>,
    hands: Query<(&XrHandPose, &GlobalTransform)>,
    mut shown: ResMut<Shown>,
    mut haptic: MessageWriter<Haptic>,
    mut before: Local<[Option<Isometry3d>; 2]>,
) {
    let holds = [controls.held::<actions::GrabLeft>(), controls.held::<actions::GrabRight>()];
    let now = Hand::ALL.map(|hand| {
        let pose = hands.iter().find(|(pose, _)| pose.hand == hand && !pose.aim);
        pose.filter(|_| holds[hand as usize]).map(|(_, place)| place.to_isometry())
    });
    for hand in Hand::ALL {
        if now[hand as usize].is_some() && before[hand as usize].is_none() {
            haptic.write(Haptic { hand, amplitude: 0.4, seconds: 0.0 });
        }
    }
    let last = std::mem::replace(&mut *before, now);
    let object = &shown.object;
    let held = Held {
        place: stage.middle + object.shift,
        rotation: object.rotation(),
        scale: object.scale,
    };
    // A hand counts from the second frame in which it holds.
    let pairs = [0, 1].map(|hand| Some((last[hand]?, now[hand]?)));
    let moved = match pairs {
        [Some(left), Some(right)] => {
            held.by_both([left.0, right.0], [left.1, right.1], [LEAST_SCALE, MOST_SCALE])
        }
        [Some((was, is)), None] | [None, Some((was, is))] => {
            held.by_one(was, is, REACH * form.reach * object.scale)
        }
        [None, None] => return,
    };
    if moved != held {
        let object = &mut shown.object;
        object.turning = false;
        object.shift = (moved.place - stage.middle).clamp_length_max(10.0);
        object.set_rotation(moved.rotation);
        object.scale = moved.scale;
    }
}

/// Shows where one would stand.
#[derive(Component)]
pub struct Marker;

/// Makes the ring on the floor.
pub fn spawn_marker(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let ring = Annulus::new(0.16, 0.2).mesh().resolution(48).build();
    commands.spawn((
        Marker,
        bevy::light::NotShadowCaster,
        Mesh3d(meshes.add(ring.rotated_by(Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2)))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.45, 0.75, 1.0),
            unlit: true,
            ..default()
        })),
        Visibility::Hidden,
    ));
}

/// Goes where the left hand points, when it is let go.
pub fn teleport(
    controls: Controls,
    stage: Res<Stage>,
    status: Res<XrStatus>,
    hands: Query<(&XrHandPose, &GlobalTransform)>,
    heads: Query<&Transform, (With<XrHead>, Without<Marker>)>,
    mut markers: Query<(&mut Transform, &mut Visibility), With<Marker>>,
    mut rig: ResMut<XrRig>,
) {
    let let_go = controls.ended::<actions::Teleport>();
    let aims = controls.held::<actions::Teleport>() || let_go;
    let running = *status == XrStatus::Running;
    let hand = hands.iter().find(|(pose, _)| pose.aim && pose.hand == Hand::Left);
    let place = hand.filter(|_| aims && running).and_then(|(_, hand)| {
        let (from, ahead) = (hand.translation(), hand.forward());
        let floor = stage.floor.unwrap_or(0.0);
        let far = (floor - from.y) / ahead.y;
        (far > 0.0 && far < FAR).then(|| from + *ahead * far)
    });
    for (mut transform, mut visibility) in &mut markers {
        let seen = place.filter(|_| !let_go);
        visibility.set_if_neq(if seen.is_some() {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        });
        if let Some(place) = seen {
            transform.set_if_neq(Transform::from_translation(place + Vec3::Y * 0.005));
        }
    }
    if let (true, Some(place)) = (let_go, place) {
        let head = heads.iter().next().map_or(Vec3::Y * 1.6, |head| head.translation);
        rig.teleport_to(head, place);
    }
}
