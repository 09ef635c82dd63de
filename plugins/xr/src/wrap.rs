//! Bevy's plugins with a headset.

use bevy::{
    app::{PluginGroup, PluginGroupBuilder},
    prelude::*,
};

use crate::{Haptic, Recentre, XrRig, XrStatus};

/// A headset for an app.
#[derive(Clone, Debug, Default)]
pub struct FarlightXr {
    _private: (),
}

impl FarlightXr {
    /// Bevy's plugins, with a headset if there is one.
    pub fn wrap(self, plugins: impl PluginGroup) -> PluginGroupBuilder {
        plugins.build().add(XrPlugin)
    }
}

struct XrPlugin;

impl Plugin for XrPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<XrStatus>()
            .init_resource::<XrRig>()
            .add_message::<Recentre>()
            .add_message::<Haptic>();
    }
}
