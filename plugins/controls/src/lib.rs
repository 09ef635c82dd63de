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
//! (`On<Start<NextMaterial>>`), mocks and queries work with them. A game's own actions are declared with
//! [`named_action!`] and added with [`AddAction::add_action`]; their bindings come from the same file.
//!
//! | | |
//! |---|---|
//! | [`Controls`], [`ActionValues`], [`ActionPerformed`] | what actions say |
//! | [`ControlsPlugin`], [`ControlsInForce`], [`ControlsStatus`] | which bindings count, where they come from, what is wrong with them |
//! | [`Rebinding`] | other inputs, chosen by pressing them, and saved |
//! | [`ActiveDevice`] | the device in hand, for help |
//! | [`InputCapture`] | what panels take for themselves |
//! | [`ActionRecorder`], [`ActionReplay`] | what actions said, said again |
//! | [`gamepads`] | gamepads in a thread of their own, and other sources of them |
//! | [`XrControllers`] | what a headset's controllers say |
//!
//! An axis's value is what was moved in this frame, in the action's unit. Drags, wheels and pinches give
//! what they moved by times the binding's scale, whatever the frame took; sticks and keys give the scale
//! for each second that they are held, by the real clock (a game that pauses or slows down its own time
//! looks around as fast as ever), for at most 0.1 s a frame. A single number takes a stick's `x`.
//!
//! A binding that asks for more buttons to be held silences those of the same input that ask for less; a
//! button counts only if it is pressed while the others are held. What is silenced, taken by a panel, or
//! down when the window loses the focus, when bindings change or when a panel closes, stays silent until
//! it is let go: nothing begins because something else ended.

pub mod actions;
mod capture;
mod compile;
mod contexts;
mod device;
mod evaluate;
mod file;
pub mod gamepads;
mod gather;
mod inputs;
mod layers;
mod plugin;
mod read;
mod rebinding;
mod recorder;
mod sample;
mod slots;
mod spawn;
mod status;
mod touch;
mod xr;

#[doc(hidden)]
pub use bevy::math::Vec2;
pub use bevy_enhanced_input;
pub use capture::InputCapture;
pub use contexts::{GlobalContext, PanelContext, SceneContext};
pub use device::ActiveDevice;
pub use farlight_bindings as bindings;
pub use file::{ControlsFile, ControlsFileError};
pub use gamepads::{GamepadReader, GamepadThreadPlugin};
pub use plugin::{ControlsInForce, ControlsPlugin, ControlsSystems, UserFile};
pub use read::{ActionPerformed, ActionSays, ActionValues, Controls};
pub use rebinding::{RebindState, RebindTarget, Rebinding, Resolve};
pub use recorder::{ActionRecorder, ActionReplay, ReplayPace};
pub use spawn::AddAction;
pub use status::ControlsStatus;
pub use xr::{XrControllers, XrHandInputs};
