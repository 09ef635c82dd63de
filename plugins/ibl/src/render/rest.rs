//! Refined pictures are shown as they are kept: nothing is drawn for them.

use bevy::{
    core_pipeline::schedule::RootNonCameraView,
    pbr::ViewLightEntities,
    prelude::*,
    render::{camera::ExtractedCamera, renderer::CurrentView},
};

use crate::camera::{Action, Step};

/// Whether the view whose schedule runs is drawn in this frame.
pub(crate) fn is_drawn(view: Option<Res<CurrentView>>, steps: Query<&Step>) -> bool {
    let step = view.and_then(|view| steps.get(view.0).ok());
    step.is_none_or(|step| step.action != Action::Present)
}

/// Leaves out the shadow maps of views that aren't drawn; those of point and spot lights, which all
/// views share, where no view is drawn.
pub(crate) fn skip_shadows(
    mut commands: Commands,
    mut views: Query<(&mut ViewLightEntities, Option<&Step>), With<ExtractedCamera>>,
    shared: Query<Entity, With<RootNonCameraView>>,
) {
    let mut drawn = false;
    for (mut lights, step) in &mut views {
        if step.is_some_and(|step| step.action == Action::Present) {
            lights.lights.clear();
        } else {
            drawn = true;
        }
    }
    if !drawn {
        for view in &shared {
            // It comes back with the next frame's lights.
            commands.entity(view).remove::<RootNonCameraView>();
        }
    }
}
