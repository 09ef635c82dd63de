//! One set of actions for keyboard and mouse, gamepads, touch screens and XR controllers.
//!
//! A game asks what is wanted, never which device says so:
//!
//! ```no_run
//! use bevy::prelude::*;
//! use farlight_controls::{Controls, ControlsPlugin, actions::{NextMaterial, Orbit}};
//!
//! App::new()
//!     .add_plugins((DefaultPlugins, ControlsPlugin::default()))
//!     .add_systems(Update, |controls: Controls, mut camera: Single<&mut Transform, With<Camera3d>>| {
//!         // Degrees in this frame, from a drag, a stick or a hand.
//!         let turn = controls.axis2::<Orbit>();
//!         camera.rotate_y(-turn.x.to_radians());
//!         if controls.started::<NextMaterial>() {
//!             info!("next, please");
//!         }
//!     })
//!     .run();
//! ```
//!
//! The types in [`actions`] are ordinary actions of `bevy_enhanced_input`: its observers
//! (`On<Start<NextMaterial>>`), mocks and queries work with them.

pub mod actions;
mod capture;
mod compile;
mod contexts;
mod device;
mod evaluate;
mod gather;
mod inputs;
mod plugin;
mod read;
mod sample;
mod slots;
mod spawn;
mod xr;

pub use bevy_enhanced_input;
pub use capture::InputCapture;
pub use contexts::{GlobalContext, PanelContext, SceneContext};
pub use device::ActiveDevice;
pub use farlight_bindings as bindings;
pub use plugin::{ControlsInForce, ControlsPlugin, ControlsSystems};
pub use read::{ActionPerformed, Controls};
pub use spawn::AddAction;
pub use xr::{XrControllers, XrHandInputs};
