//! Panels of settings for games: on screen, or on a quad in the world that follows lazily and is
//! pointed at with a controller, the mouse or the gaze.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use farlight_controls::ControlsPlugin;
//! use farlight_panel::{AddPanel, PanelPlugin};
//!
//! #[derive(Resource, Reflect, Default)]
//! #[reflect(Resource, Default)]
//! struct Weather {
//!     /// How hard it rains, in mm an hour.
//!     #[reflect(@0.0..=50.0_f32)]
//!     rain: f32,
//! }
//!
//! App::new()
//!     .add_plugins((DefaultPlugins, ControlsPlugin::default(), PanelPlugin::default()))
//!     .init_resource::<Weather>()
//!     // Sliders, switches and choices come from the type.
//!     .add_panel_resource::<Weather>("Weather")
//!     .run();
//! ```
//!
//! The actions `Menu` and `Help` of `farlight_controls` open panels; [`PanelState`] does it from
//! code. [`Notification`]s say what happened.

mod fields;
mod help;
mod menu;
mod notify;
mod plot;
mod plugin;
mod ray;
mod screen;
mod sections;
mod settings;
mod state;
mod steer;
mod style;
mod world;

pub use bevy_egui::{self, egui};
pub use farlight_core::field;
pub use plot::plot;
pub use plugin::{PanelPlugin, PanelSystems};
pub use ray::PanelRay;
pub use sections::{AddPanel, button_row, choice_row, slider_row, switch_row, text_row};
pub use settings::PanelSettings;
pub use state::{Notification, PanelCamera, PanelEye, PanelPlace, PanelState, PanelViewer};
pub use world::WorldPanel;
