//! With an OpenXR runtime.

mod action;
mod eyes;
mod input;
mod probe;
mod session;
mod space;

use std::borrow::Cow;

use bevy::{app::PluginGroupBuilder, prelude::*, render::RenderPlugin};
use bevy_mod_openxr::{
    action_binding::OxrActionBindingPlugin,
    action_set_attaching::OxrActionAttachingPlugin,
    action_set_syncing::OxrActionSyncingPlugin,
    exts::OxrExtensions,
    init::OxrInitPlugin,
    poll_events::OxrEventsPlugin,
    render::OxrRenderPlugin,
    resources::OxrSessionConfig,
    spaces::{OxrSpacePatchingPlugin, OxrSpatialPlugin},
    types::{AppInfo, Version},
};
use bevy_mod_xr::session::{XrSessionPlugin, XrState};

use crate::{FarlightXr, XrStatus};

pub(crate) use probe::Found;

/// Puts the runtime's plugins into Bevy's, if there is a runtime with a headset.
pub(crate) fn wrap(
    group: PluginGroupBuilder,
    settings: &FarlightXr,
) -> (PluginGroupBuilder, Result<Found, String>) {
    if !group.enabled::<RenderPlugin>() {
        return (group, Err("the app doesn't draw".into()));
    }
    let found = match probe::find(&settings.app_name) {
        Ok(found) => found,
        Err(reason) => return (group, Err(reason)),
    };
    let mut exts = OxrExtensions::default();
    exts.raw_mut().ext_hand_interaction = found.hand_interaction;
    exts.raw_mut().ext_local_floor = found.local_floor;
    let init = OxrInitPlugin {
        app_info: AppInfo {
            name: Cow::Owned(settings.app_name.clone()),
            version: Version(0, 1, 0),
        },
        exts,
        synchronous_pipeline_compilation: settings.synchronous_pipelines,
        ..default()
    };
    let session = OxrSessionConfig {
        blend_mode_preference: found.blend_modes(settings.see_through),
        resolutions: Some(vec![found.resolution(settings.resolution_scale)]),
        ..default()
    };
    let group = group
        .disable::<RenderPlugin>()
        .add_before::<RenderPlugin>(Configure(session))
        .add_before::<RenderPlugin>(XrSessionPlugin { auto_handle: true })
        .add_before::<RenderPlugin>(init)
        .add(OxrEventsPlugin)
        .add(OxrRenderPlugin { spawn_cameras: false, ..default() })
        .add(OxrActionAttachingPlugin)
        .add(OxrActionBindingPlugin)
        .add(OxrActionSyncingPlugin)
        .add(OxrSpatialPlugin)
        .add(OxrSpacePatchingPlugin);
    (group, Ok(found))
}

/// Puts the configuration of sessions where it is looked for.
struct Configure(OxrSessionConfig);

impl Plugin for Configure {
    fn build(&self, app: &mut App) {
        app.insert_resource(self.0.clone());
    }
}

/// Adds what is ours.
pub(crate) fn build(app: &mut App, settings: &FarlightXr, found: &Found) {
    if app.world().get_resource::<XrState>() != Some(&XrState::Available) {
        let reason = format!("{} can't draw with this machine's graphics", found.runtime);
        app.insert_resource(XrStatus::Unavailable(reason));
        return;
    }
    app.insert_resource(XrStatus::Idle);
    session::build(app, settings);
    space::build(app, settings);
    eyes::build(app, settings);
    input::build(app, found);
}
