//! Input bindings of the Farlight suite, without an engine: what can be pressed ([`Input`]), what it
//! does ([`ACTIONS`]), which does which ([`Bindings`]), for which device; read from RON, checked, and
//! explained to people.
//!
//! A file:
//!
//! ```ron
//! ControlsSettings(
//!     invert_zoom: true,
//!     bindings: {
//!         "menu": (keyboard_mouse: ["KeyM"], gamepad: ["Start"], xr: ["Left.Secondary"]),
//!         "orbit": (
//!             keyboard_mouse: ["LeftDrag"],
//!             gamepad: [(input: "LeftStick", dead_zone: 0.15, curve: 2.0, scale: 120.0)],
//!         ),
//!     },
//! )
//! ```

mod action;
mod binding;
mod bindings;
mod defaults;
mod device;
mod help;
mod input;
mod key;
mod recording;
mod stick;

pub use action::{ACTIONS, ActionInfo, ActionKind, Context, action};
pub use binding::{Binding, BindingError, Held, Source};
pub use bindings::{ActionBindings, Bindings, Problem, Sensitivity};
pub use defaults::Preset;
pub use device::{Device, Profile};
pub use help::{HelpLine, help};
pub use input::{Hand, Input, Mouse, Pad, Shape, Touch, UnknownInput, Wii, Xr};
pub use key::{KEYS, Key};
pub use recording::{
    MAX_RECORDED_ACTIONS, MAX_RECORDED_EVENTS, RecordedEvent, RecordedFrame, Recording,
    RecordingError, RecordingFileError,
};
pub use stick::Direction;
