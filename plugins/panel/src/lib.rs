//! Panels of settings for games: on screen, or on a quad in the world that follows lazily and is
//! pointed at with a controller, the mouse or the gaze.
//!
//! ```no_run
//! use bevy::prelude::*;
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
//!     .add_plugins((DefaultPlugins, PanelPlugin::default()))
//!     .init_resource::<Weather>()
//!     // Sliders, switches and choices come from the type.
//!     .add_panel_resource::<Weather>("Weather")
//!     .run();
//! ```

mod plugin;
mod ray;
mod sections;
mod state;

pub use bevy_egui::{self, egui};
pub use plugin::PanelPlugin;
pub use ray::PanelRay;
pub use sections::AddPanel;
pub use state::{Notification, PanelPlace, PanelState};
