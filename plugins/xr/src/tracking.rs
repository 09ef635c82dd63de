//! What a headset says, and how eyes, head and hands follow it.

use bevy::{camera::CameraUpdateSystems, ecs::lifecycle::Add, prelude::*};
use farlight_bindings::Hand;
use farlight_controls::ControlsSystems;

use crate::{EyeProjection, Fov, Recentre, XrEye, XrHandPose, XrHead, XrRig, XrRoot, rig::Origin};

/// Where eyes and hands are, in the headset's own space: metres from its floor's middle, y up. The
/// runtime writes it each frame; so may tests and simulations, where there is none.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct XrTracking {
    /// Both eyes, left first; `None` before anybody has worn the headset.
    pub eyes: Option<[XrView; 2]>,
    /// The left and the right hand.
    pub hands: [XrHandTracking; 2],
}

/// How an eye sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct XrView {
    /// Where it is; it looks along -z.
    pub pose: Isometry3d,
    /// How far it sees to each side.
    pub fov: Fov,
}

/// Where a hand is; `None` while it isn't tracked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct XrHandTracking {
    /// OpenXR's grip pose: in the middle of the palm, -z along the handle.
    pub grip: Option<Isometry3d>,
    /// OpenXR's aim pose: -z is where it points.
    pub aim: Option<Isometry3d>,
}

impl XrTracking {
    /// The head: between the eyes.
    pub fn head(&self) -> Option<Isometry3d> {
        let [left, right] = self.eyes?.map(|view| view.pose);
        let middle = (left.translation + right.translation) / 2.0;
        Some(Isometry3d::new(middle, left.rotation.slerp(right.rotation, 0.5)))
    }

    /// One hand.
    pub fn hand(&self, hand: Hand) -> &XrHandTracking {
        &self.hands[hand as usize]
    }

    /// One hand, to be written.
    pub fn hand_mut(&mut self, hand: Hand) -> &mut XrHandTracking {
        &mut self.hands[hand as usize]
    }
}

/// When this crate's systems run.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum XrSystems {
    /// `PreUpdate`: what is pressed is read, and where hands are, and hands follow; before
    /// `ControlsSystems::Sample`.
    Read,
    /// `PostUpdate`: rig, eyes and head take their places; before transforms are propagated.
    Follow,
}

pub(crate) fn build(app: &mut App) {
    app.init_resource::<XrTracking>()
        .init_resource::<Origin>()
        .init_resource::<XrRig>()
        .add_message::<Recentre>()
        .configure_sets(PreUpdate, XrSystems::Read.before(ControlsSystems::Sample))
        .configure_sets(
            PostUpdate,
            XrSystems::Follow.before(TransformSystems::Propagate).before(CameraUpdateSystems),
        )
        .add_systems(PreUpdate, (place_root, follow_hands).chain().in_set(XrSystems::Read))
        .add_systems(
            PostUpdate,
            (recentre, place_root, follow_eyes, follow_head).chain().in_set(XrSystems::Follow),
        )
        .add_observer(adopt::<XrEye>)
        .add_observer(adopt::<XrHead>)
        .add_observer(adopt::<XrHandPose>);
    app.world_mut().spawn((Name::new("xr rig"), XrRoot));
}

/// What follows the headset is a child of the rig.
fn adopt<C: Component>(
    added: On<Add, C>,
    orphans: Query<(), Without<ChildOf>>,
    root: Single<Entity, With<XrRoot>>,
    mut commands: Commands,
) {
    if orphans.contains(added.entity) {
        commands.entity(added.entity).insert(ChildOf(*root));
    }
}

fn recentre(
    mut wishes: MessageReader<Recentre>,
    tracking: Res<XrTracking>,
    mut origin: ResMut<Origin>,
) {
    if wishes.read().count() > 0
        && let Some(head) = tracking.head()
    {
        origin.recentre(head);
    }
}

fn place_root(rig: Res<XrRig>, mut roots: Query<&mut Transform, With<XrRoot>>) {
    for mut transform in &mut roots {
        transform.set_if_neq(rig.0);
    }
}

fn follow_eyes(
    tracking: Res<XrTracking>,
    origin: Res<Origin>,
    mut eyes: Query<(&XrEye, &mut Transform, &mut Projection)>,
) {
    let Some(views) = tracking.eyes else { return };
    for (eye, mut transform, mut projection) in &mut eyes {
        let Some(view) = views.get(eye.index as usize) else { continue };
        transform.set_if_neq(Transform::from_isometry(origin.to_rig(view.pose)));
        let Projection::Custom(custom) = projection.bypass_change_detection() else { continue };
        let Some(seen) = custom.get_mut::<EyeProjection>() else { continue };
        if seen.fov != view.fov && view.fov.is_sound() {
            seen.fov = view.fov;
            projection.set_changed();
        }
    }
}

fn follow_head(
    tracking: Res<XrTracking>,
    origin: Res<Origin>,
    mut heads: Query<&mut Transform, With<XrHead>>,
) {
    let Some(head) = tracking.head() else { return };
    for mut transform in &mut heads {
        transform.set_if_neq(Transform::from_isometry(origin.to_rig(head)));
    }
}

/// Hands are where they are before anything of the frame asks.
pub(crate) fn follow_hands(
    tracking: Res<XrTracking>,
    origin: Res<Origin>,
    rig: Res<XrRig>,
    root: Single<Entity, With<XrRoot>>,
    mut hands: Query<(
        &XrHandPose,
        &mut Transform,
        &mut GlobalTransform,
        &mut Visibility,
        Option<&ChildOf>,
    )>,
) {
    for (pose, mut transform, mut global, mut visibility, parent) in &mut hands {
        let hand = tracking.hand(pose.hand);
        let place = if pose.aim { hand.aim } else { hand.grip };
        visibility.set_if_neq(match place {
            Some(_) => Visibility::Inherited,
            None => Visibility::Hidden,
        });
        let Some(place) = place else { continue };
        let place = Transform::from_isometry(origin.to_rig(place));
        transform.set_if_neq(place);
        if parent.is_some_and(|parent| parent.parent() == *root) {
            global.set_if_neq(GlobalTransform::from(rig.0) * place);
        }
    }
}
