//! Input bindings of the Farlight suite, without an engine: what can be pressed ([`Input`]), what it
//! does ([`ACTIONS`]), which does which ([`Bindings`]), for which device; read from RON, checked, and
//! explained to people.
//!
//! A file, of which everything may be left out:
//!
//! ```ron
//! ControlsSettings(
//!     preset: Room,
//!     invert_zoom: true,
//!     bindings: {
//!         "menu": (keyboard_mouse: ["KeyM"], gamepad: ["Start"], xr: ["Left.Secondary"]),
//!         "orbit": (
//!             keyboard_mouse: ["LeftDrag"],
//!             gamepad: [(input: "RightStick", dead_zone: 0.15, curve: 2.0, scale: 120.0)],
//!         ),
//!     },
//! )
//! ```
//!
//! ```
//! use farlight_bindings::{Bindings, Device, first_hint};
//!
//! let text = "ControlsSettings(bindings: {\"menu\": (keyboard_mouse: [\"Tab\"])})";
//! let bindings = Bindings::from_ron(text)?;
//! assert!(bindings.check(&[]).is_empty());
//! assert!(bindings.conflicts(Device::KeyboardMouse, &[]).is_empty());
//! assert_eq!(first_hint(&bindings, Device::KeyboardMouse), "Tab: menu, F1: help");
//! # Ok::<(), farlight_bindings::FileError>(())
//! ```
//!
//! | | |
//! |---|---|
//! | [`Bindings::from_ron`], [`Bindings::to_ron`], [`defaults_ron`] | files |
//! | [`Bindings::check`], [`Bindings::conflicts`], [`Bindings::rivals`] | what is wrong, what does two things at once |
//! | [`Binding::is_masked_by`], [`Binding::takes_from`], [`Input::overlaps`], [`Direction`] | which binding is silent while another is used |
//! | [`help`], [`help_text`], [`first_hint`], [`table`] | words for people |
//! | [`Recording`] | what actions said, as a text |

mod action;
mod binding;
mod bindings;
mod check;
mod conflicts;
mod defaults;
mod device;
mod file;
mod help;
mod input;
mod key;
mod label;
mod recording;
mod serial;
mod stick;
mod table;
mod text;

pub use action::{ACTIONS, ActionInfo, ActionKind, Context, action};
pub use binding::{Binding, Held, Source};
pub use bindings::{ActionBindings, Bindings, Sensitivity};
pub use check::{Problem, Severity};
pub use conflicts::Conflict;
pub use defaults::Preset;
pub use device::{Device, Profile};
pub use farlight_ron::FileError;
pub use file::{MAX_FILE, defaults_ron};
pub use help::{HelpLine, first_hint, help, help_text};
pub use input::{Hand, Input, Mouse, Pad, Shape, Touch, UnknownInput, Wii, Xr};
pub use key::{KEYS, Key};
pub use recording::{
    MAX_RECORDED_ACTIONS, MAX_RECORDED_EVENTS, RecordedEvent, RecordedFrame, Recording,
    RecordingError, RecordingFileError,
};
pub use stick::Direction;
pub use table::{APPENDIX_A, documentation, table};
pub use text::BindingError;
