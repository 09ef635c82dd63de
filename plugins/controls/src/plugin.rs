//! The plugin.

use std::path::PathBuf;

use bevy::{
    asset::AssetLoadFailedEvent,
    input::{InputSystems, keyboard::KeyboardFocusLost, touch::TouchInput},
    prelude::*,
};
use bevy_enhanced_input::prelude::*;
use farlight_bindings::Bindings;

use crate::{
    ActionPerformed, ActionRecorder, ActionReplay, ActiveDevice, ControlsFile, ControlsStatus,
    GamepadThreadPlugin, InputCapture, Rebinding, XrControllers, actions,
    contexts::{GlobalContext, PanelContext, SceneContext},
    device,
    file::ControlsLoader,
    layers::{self, Layers},
    read::{self, ActionEntities},
    rebinding, recorder,
    sample::{self, Sampling},
    spawn,
};

/// Input actions for every device.
#[derive(Clone, Debug)]
pub struct ControlsPlugin {
    /// An asset with bindings, such as `config/game.controls.ron`; without one, the defaults count.
    /// Changes of the file reach the game when the asset server watches files.
    pub file: Option<String>,
    /// Where the user's own changes are kept.
    pub user_file: UserFile,
    /// Whether gamepads of the machine are read, in a thread of their own. If the app has Bevy's own
    /// reader of them (`bevy_gilrs`), that one reads.
    pub gamepads: bool,
}

impl Default for ControlsPlugin {
    fn default() -> Self {
        Self { file: None, user_file: UserFile::default(), gamepads: true }
    }
}

/// Where the user's own changes are kept. They go over the game's file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum UserFile {
    /// `controls.ron` in a folder with the program's name in the user's folder for configuration:
    /// `~/.config/my_game/controls.ron` on Linux.
    #[default]
    OfTheProgram,
    /// This file.
    At(PathBuf),
    /// Nowhere: changes last as long as the program runs.
    Nowhere,
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
    /// What the thread of gamepads has read becomes Bevy's messages; before Bevy's `InputSystems`.
    Gamepads,
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
            .init_resource::<ControlsStatus>()
            .init_resource::<Rebinding>()
            .init_resource::<ActionRecorder>()
            .init_resource::<ActionReplay>()
            .add_message::<ActionPerformed>()
            .add_message::<KeyboardFocusLost>()
            .add_message::<TouchInput>()
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
                    // What has nothing to do is no task of the executor, which would allocate.
                    (
                        sample::rebind.run_if(sample::is_stale),
                        sample::follow_panel.run_if(resource_changed::<InputCapture>),
                        sample::sample,
                        device::follow_device,
                        rebinding::rebind.run_if(|rebinding: Res<Rebinding>| rebinding.is_busy()),
                        recorder::replay.run_if(|replay: Res<ActionReplay>| replay.is_playing()),
                    )
                        .chain()
                        .in_set(ControlsSystems::Sample),
                    (
                        read::announce,
                        recorder::record
                            .run_if(|recorder: Res<ActionRecorder>| recorder.is_recording()),
                    )
                        .in_set(ControlsSystems::Announce),
                ),
            );
        if app.is_plugin_added::<AssetPlugin>() {
            app.init_asset::<ControlsFile>().init_asset_loader::<ControlsLoader>().add_systems(
                PreUpdate,
                layers::follow_file
                    .run_if(
                        on_message::<AssetEvent<ControlsFile>>
                            .or_eager(on_message::<AssetLoadFailedEvent<ControlsFile>>),
                    )
                    .before(ControlsSystems::Sample),
            );
        }
        let user_file = match &self.user_file {
            UserFile::OfTheProgram => layers::default_user_file(),
            UserFile::At(path) => Some(path.clone()),
            UserFile::Nowhere => None,
        };
        layers::open(app.world_mut(), self.file.as_deref(), user_file);
        app.add_systems(
            Last,
            (
                layers::check.run_if(resource_changed::<ControlsInForce>),
                layers::save.run_if(|layers: Res<Layers>| layers.is_saving()),
            )
                .chain(),
        );
        actions::add_all(app);
        #[cfg(not(target_family = "wasm"))]
        if self.gamepads && !app.is_plugin_added::<GamepadThreadPlugin>() {
            app.add_plugins(GamepadThreadPlugin::of_the_machine());
        }
    }
}
