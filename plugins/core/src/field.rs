//! What settings say of their fields, for panels: attributes of `Reflect`.
//!
//! ```
//! # use bevy::prelude::*;
//! # use farlight_core::field::{Hidden, Logarithmic, Unit};
//! #[derive(Resource, Reflect)]
//! #[reflect(Resource)]
//! struct Lamp {
//!     /// Doc comments are shown where the pointer rests.
//!     #[reflect(@0.1..=10_000.0_f32, @Unit("lm"), @Logarithmic)]
//!     power: f32,
//!     #[reflect(@Hidden)]
//!     seed: u64,
//! }
//! ```
//!
//! A range (`RangeInclusive` of the field's own type) makes a slider.

use bevy::prelude::*;

/// The unit of a number: `"lux"`, `"ms"`, `"m"`. Of a fraction, `"%"` shows 0.25 as 25 %.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub struct Unit(pub &'static str);

/// Sliders stop at multiples of it, and keys move by it.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct Step(pub f64);

/// Equal ways on the slider are equal factors. (Ranges over three decades or more are so anyway.)
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub struct Logarithmic;

/// No panel shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub struct Hidden;

/// Panels show it and don't change it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub struct ReadOnly;

/// What panels call it, where the field's name doesn't say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub struct Label(pub &'static str);

/// A rotation that people change as a turn about the vertical axis, in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub struct Turn;

/// A type whose changes start long work: panels hand them over when the slider is let go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub struct Costly;
