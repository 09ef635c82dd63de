//! The plugin.

use bevy::prelude::*;
use bevy_egui::EguiPlugin;
use farlight_controls::{Controls, actions};

use crate::{
    sections::Sections,
    state::{Notification, PanelState},
};

/// Panels of settings. Needs `ControlsPlugin`.
#[derive(Clone, Debug, Default)]
pub struct PanelPlugin {
    _private: (),
}

impl Plugin for PanelPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<EguiPlugin>() {
            app.add_plugins(EguiPlugin::default());
        }
        app.init_resource::<PanelState>()
            .init_resource::<Sections>()
            .add_message::<Notification>()
            .add_systems(Update, open_and_close);
    }
}

fn open_and_close(controls: Controls, mut state: ResMut<PanelState>) {
    if controls.started::<actions::Menu>() {
        state.menu = !state.menu;
    }
    if controls.started::<actions::Help>() {
        state.help = !state.help;
    }
}
