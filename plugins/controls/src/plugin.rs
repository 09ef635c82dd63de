//! The plugin.

use bevy::{input::InputSystems, prelude::*};
use bevy_enhanced_input::prelude::*;
use farlight_bindings::Bindings;

use crate::{
    ActionPerformed, ActiveDevice, InputCapture, XrControllers, actions,
    contexts::{GlobalContext, PanelContext, SceneContext},
    read,
    sample::{self, Sampling},
    spawn,
};

/// Input actions for every device.
#[derive(Clone, Debug, Default)]
pub struct ControlsPlugin {
    /// An asset with bindings, such as `config/controls.ron`; without one, the defaults count.
    pub file: Option<String>,
}

/// The bindings that count now. Change them, and the next frame follows.
#[derive(Resource, Clone, Debug, Default)]
pub struct ControlsInForce {
    /// Which inputs do what.
    pub bindings: Bindings,
}

/// Systems of `PreUpdate`, in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ControlsSystems {
    /// Bindings become values; after Bevy's `InputSystems`, before `EnhancedInputSystems::Update`.
    Sample,
    /// Actions have their values; after `EnhancedInputSystems::Apply`.
    Announce,
}

impl Plugin for ControlsPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<EnhancedInputPlugin>() {
            app.add_plugins(EnhancedInputPlugin);
        }
        app.add_input_context::<SceneContext>()
            .add_input_context::<GlobalContext>()
            .add_input_context::<PanelContext>()
            .init_resource::<ControlsInForce>()
            .init_resource::<Sampling>()
            .init_resource::<ActiveDevice>()
            .init_resource::<InputCapture>()
            .init_resource::<XrControllers>()
            .add_message::<ActionPerformed>()
            .configure_sets(
                PreUpdate,
                (
                    ControlsSystems::Sample
                        .after(InputSystems)
                        .before(EnhancedInputSystems::Update),
                    ControlsSystems::Announce.after(EnhancedInputSystems::Apply),
                ),
            )
            .add_systems(
                PreUpdate,
                (
                    (spawn::rebind, sample::sample).chain().in_set(ControlsSystems::Sample),
                    read::announce.in_set(ControlsSystems::Announce),
                ),
            );
        actions::add_all(app);
    }
}
