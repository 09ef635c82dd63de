//! Whether panels are on the screen or in the world.

use bevy::prelude::*;

use crate::{PanelPlace, PanelSettings, PanelViewer};

/// The camera that draws the texture of a panel in the world.
#[derive(Component)]
pub(crate) struct Canvas;

impl PanelPlace {
    /// Whether this is in the world, with or without somebody who wears a headset.
    pub(super) fn is_world(self, viewed: bool) -> bool {
        match self {
            Self::Screen => false,
            Self::World => true,
            Self::Auto => viewed,
        }
    }
}

/// Whether they are in the world.
pub(crate) fn is_world(world: &mut World) -> bool {
    let mut viewers = world.query_filtered::<(), With<PanelViewer>>();
    let viewed = viewers.iter(world).next().is_some();
    world.resource::<PanelSettings>().place.is_world(viewed)
}
