//! The plugin.

use std::path::PathBuf;

use bevy::{input::InputSystems, prelude::*};
use bevy_enhanced_input::prelude::*;
use farlight_bindings::Bindings;

use crate::{
    ActionPerformed, ActiveDevice, InputCapture, XrControllers, actions,
    contexts::{GlobalContext, PanelContext, SceneContext},
    device,
    read::{self, ActionEntities},
    sample::{self, Sampling},
    spawn,
};

/// Input actions for every device.
#[derive(Clone, Debug)]
pub struct ControlsPlugin {
    /// An asset with bindings, such as `config/controls.ron`; without one, the defaults count.
    pub file: Option<String>,
    /// Where the user's own changes are kept; `None` keeps none.
    pub user_file: Option<PathBuf>,
    /// Whether gamepads of the machine are read (unless the app has Bevy's own reader of them).
    pub gamepads: bool,
}

impl Default for ControlsPlugin {
    fn default() -> Self {
        Self { file: None, user_file: None, gamepads: true }
    }
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
            .init_resource::<ActionEntities>()
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
            .add_systems(PreStartup, spawn::add_contexts)
            .add_systems(
                PreUpdate,
                (
                    (sample::rebind, sample::follow_panel, sample::sample, device::follow_device)
                        .chain()
                        .in_set(ControlsSystems::Sample),
                    read::announce.in_set(ControlsSystems::Announce),
                ),
            );
        actions::add_all(app);
    }
}
