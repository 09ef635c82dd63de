//! The space that the headset's places are in.

use bevy::{
    prelude::*,
    render::{RenderApp, extract_resource::ExtractResourcePlugin},
};
use bevy_mod_openxr::session::OxrSession;
use bevy_mod_xr::{
    session::{XrPreDestroySession, XrSessionCreated},
    spaces::XrPrimaryReferenceSpace,
};
use openxr::ReferenceSpaceType;

use crate::{FarlightXr, XrSpace, rig::Origin};

/// What was asked for.
#[derive(Resource, Clone, Copy)]
struct Wanted {
    space: XrSpace,
    eye_height: f32,
}

pub(super) fn build(app: &mut App, settings: &FarlightXr) {
    app.add_plugins(ExtractResourcePlugin::<XrPrimaryReferenceSpace>::default())
        .insert_resource(Wanted { space: settings.space, eye_height: settings.eye_height })
        .add_systems(XrSessionCreated, choose)
        .add_systems(XrPreDestroySession, forget);
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app.add_systems(XrPreDestroySession, forget);
    }
}

fn forget(mut commands: Commands) {
    commands.remove_resource::<XrPrimaryReferenceSpace>();
}

fn choose(
    session: Option<Res<OxrSession>>,
    wanted: Res<Wanted>,
    mut origin: ResMut<Origin>,
    mut commands: Commands,
) {
    let Some(session) = session else { return };
    let known = session.enumerate_reference_spaces().unwrap_or_default();
    for kind in in_order(wanted.space) {
        if !known.contains(&kind) {
            continue;
        }
        match session.create_reference_space(kind, Isometry3d::IDENTITY) {
            Ok(space) => {
                let has_floor = kind != ReferenceSpaceType::LOCAL;
                let is_meant = wanted.space == XrSpace::Local;
                let lift = if has_floor || is_meant { 0.0 } else { wanted.eye_height };
                origin.set_if_neq(Origin { rig_from_tracking: Isometry3d::IDENTITY, lift });
                debug!("the headset's space is {kind:?}, {lift} m above the floor");
                commands.insert_resource(XrPrimaryReferenceSpace(space));
                return;
            }
            Err(error) => debug!("the headset's space can't be {kind:?}: {error}"),
        }
    }
    error!("the OpenXR runtime has none of the spaces that it must have");
}

/// What was asked for, and what comes next to it.
fn in_order(space: XrSpace) -> impl Iterator<Item = ReferenceSpaceType> {
    let all = [
        (XrSpace::Stage, ReferenceSpaceType::STAGE),
        (XrSpace::LocalFloor, ReferenceSpaceType::LOCAL_FLOOR),
        (XrSpace::Local, ReferenceSpaceType::LOCAL),
    ];
    all.into_iter().skip_while(move |(name, _)| *name != space).map(|(_, kind)| kind)
}
