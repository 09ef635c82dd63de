//! Lights that plugins make.

use bevy::prelude::*;

/// Marks a light that a plugin made from something else, for example directional lights that stand
/// for an environment map.
///
/// Such lights shade like any other, but lighting solvers don't read them as lights of the scene:
/// their energy is already counted where they came from.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct DerivedLight;
