//! Taking things in hand: what a hand touches, or what it points at; on the desktop what is in the middle
//! of the view.

use bevy::prelude::*;
use farlight::{
    controls::{
        Controls,
        actions::{GrabLeft, GrabRight},
        bindings::Hand,
    },
    xr::{DesktopCamera, Haptic, XrHandPose, XrStatus},
};

use super::plan::Floor;

/// How far away something is taken that is pointed at, in metres.
const FAR: f32 = 4.0;
/// Who points past something by so many degrees means it all the same.
const NEARLY: f32 = 2.5;

/// Something to take in hand.
#[derive(Component, Clone, Copy, Debug)]
pub struct Grabbable {
    /// Metres from its middle within which a hand reaches it.
    pub reach: f32,
    /// Metres from its middle to what it stands on.
    pub half: f32,
    /// Whether it stays in the air where it is let go; otherwise it falls.
    pub floats: bool,
}

/// Who holds something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// A hand that touches it.
    Near(Hand),
    /// A hand that points at it.
    Far(Hand),
    /// The person at the desk.
    View,
}

/// It is being held.
#[derive(Component, Clone, Copy, Debug)]
pub struct Held {
    /// By whom.
    pub by: Holder,
    /// Where it is, seen from there.
    offset: Transform,
}

/// It is falling, at so many metres a second.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Falling(f32);

/// Systems of taking things in hand.
pub fn plugin(app: &mut App) {
    app.add_systems(Update, (take, carry, fall).chain());
}

/// What of several things is meant by somebody at `from`: the nearest that is touched, or pointed at.
fn meant(
    from: &GlobalTransform,
    touch: bool,
    things: &Query<(Entity, &Grabbable, &GlobalTransform, Option<&Held>)>,
) -> Option<Entity> {
    let mut best: Option<(f32, Entity)> = None;
    for (entity, thing, place, held) in things {
        let to = place.translation() - from.translation();
        let distance = to.length();
        let within = if touch {
            distance < thing.reach + 0.05
        } else {
            let ahead = to.dot(from.forward().into());
            let beside = (distance * distance - ahead * ahead).max(0.0).sqrt();
            ahead > 0.0
                && distance < FAR
                && beside < thing.reach + distance * NEARLY.to_radians().tan()
        };
        if held.is_none() && within && best.is_none_or(|(nearest, _)| distance < nearest) {
            best = Some((distance, entity));
        }
    }
    best.map(|(_, entity)| entity)
}

fn take(
    mut commands: Commands,
    controls: Controls,
    status: Option<Res<XrStatus>>,
    things: Query<(Entity, &Grabbable, &GlobalTransform, Option<&Held>)>,
    hands: Query<(&XrHandPose, &GlobalTransform)>,
    views: Query<(&GlobalTransform, &Camera), With<DesktopCamera>>,
    mut haptics: MessageWriter<Haptic>,
) {
    let actions = [
        (Hand::Left, controls.started::<GrabLeft>(), controls.ended::<GrabLeft>()),
        (Hand::Right, controls.started::<GrabRight>(), controls.ended::<GrabRight>()),
    ];
    let worn = !hands.is_empty() && status.is_none_or(|status| !matches!(*status, XrStatus::Idle));
    for (hand, started, ended) in actions {
        let holds = |by: Holder| things.iter().find(|(.., held)| held.is_some_and(|h| h.by == by));
        let mut let_go = |entity: Entity, thing: &Grabbable| {
            commands.entity(entity).remove::<Held>();
            if !thing.floats {
                commands.entity(entity).insert(Falling::default());
            }
        };
        if let Some((entity, thing, ..)) = holds(Holder::Near(hand)).or(holds(Holder::Far(hand))) {
            if ended {
                let_go(entity, thing);
            }
            continue;
        }
        // At a desk the same key takes and lets go.
        let at_desk = !worn && started;
        if let (true, Some((entity, thing, ..))) = (at_desk, holds(Holder::View)) {
            let_go(entity, thing);
            continue;
        }
        if !started {
            continue;
        }
        let pose = |aim: bool| {
            hands.iter().find(|(pose, _)| pose.hand == hand && pose.aim == aim).map(|(_, at)| at)
        };
        let view = views.iter().find(|(_, camera)| camera.is_active).map(|(at, _)| at);
        let ways = [
            (pose(false).filter(|_| worn), true, Holder::Near(hand)),
            (pose(true).filter(|_| worn), false, Holder::Far(hand)),
            (view.filter(|_| !worn), false, Holder::View),
        ];
        let found = ways.into_iter().find_map(|(from, touch, by)| {
            let from = from?;
            meant(from, touch, &things).map(|entity| (from, entity, by))
        });
        let Some((from, entity, by)) = found else { continue };
        let Ok((.., place, _)) = things.get(entity) else { continue };
        let offset = Transform::from_matrix(from.to_matrix().inverse() * place.to_matrix());
        commands.entity(entity).insert(Held { by, offset }).remove::<Falling>();
        haptics.write(Haptic { hand, amplitude: 0.5, seconds: 0.03 });
    }
}

/// What is held follows; it doesn't go into walls.
fn carry(
    floor: Res<Floor>,
    mut held: Query<(&Held, &Grabbable, &mut Transform), Without<DesktopCamera>>,
    hands: Query<(&XrHandPose, &GlobalTransform)>,
    views: Query<(&GlobalTransform, &Camera), With<DesktopCamera>>,
) {
    for (held, thing, mut transform) in &mut held {
        let pose = |hand: Hand, aim: bool| {
            hands.iter().find(|(pose, _)| pose.hand == hand && pose.aim == aim).map(|(_, at)| at)
        };
        let from = match held.by {
            Holder::Near(hand) => pose(hand, false),
            Holder::Far(hand) => pose(hand, true),
            Holder::View => views.iter().find(|(_, camera)| camera.is_active).map(|(at, _)| at),
        };
        let Some(from) = from else { continue };
        let (_, rotation, _) = from.to_scale_rotation_translation();
        let place = from.transform_point(held.offset.translation);
        let fits = [Vec3::ZERO, Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z]
            .into_iter()
            .all(|to| {
                let at = place + to * thing.half;
                !floor.blocks(at) && floor.building.space(at).is_some()
            });
        if fits {
            transform.translation = place;
        }
        // What hangs in the air stays upright.
        if !thing.floats {
            transform.rotation = rotation * held.offset.rotation;
        }
    }
}

/// What was let go comes down upright onto what is below.
fn fall(
    mut commands: Commands,
    time: Res<Time>,
    floor: Res<Floor>,
    mut falling: Query<(Entity, &Grabbable, &mut Falling, &mut Transform)>,
) {
    let step = time.delta_secs().min(0.05);
    for (entity, thing, mut falling, mut transform) in &mut falling {
        let feet = transform.translation - Vec3::Y * thing.half;
        let ground = floor.support(feet) + thing.half;
        falling.0 += 9.81 * step;
        transform.translation.y = (transform.translation.y - falling.0 * step).max(ground);
        let (yaw, ..) = transform.rotation.to_euler(EulerRot::YXZ);
        let upright = Quat::from_rotation_y(yaw);
        transform.rotation = transform.rotation.slerp(upright, 1.0 - (-step / 0.06).exp());
        let is_upright = transform.rotation.angle_between(upright) < 0.01;
        if transform.translation.y <= ground && is_upright {
            transform.rotation = upright;
            commands.entity(entity).remove::<Falling>();
        }
    }
}
