//! Whether panels are on the screen or in the world.

use bevy::prelude::*;

use crate::{PanelPlace, PanelSettings, PanelViewer};

/// The camera that draws the texture of a panel in the world.
#[derive(Component)]
pub(crate) struct Canvas;

/// Whether they are in the world.
pub(crate) fn is_world(world: &mut World) -> bool {
    match world.resource::<PanelSettings>().place {
        PanelPlace::Screen => false,
        PanelPlace::World => true,
        PanelPlace::Auto => {
            let mut viewers = world.query_filtered::<(), With<PanelViewer>>();
            viewers.iter(world).next().is_some()
        }
    }
}
