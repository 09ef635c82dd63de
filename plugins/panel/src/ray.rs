//! What points at panels in the world.

use bevy::prelude::*;
use farlight_bindings::Hand;

/// A ray from its entity's place along its -z: of a controller, of the gaze, of a test.
#[derive(Component, Clone, Debug, Default)]
#[require(Transform)]
pub struct PanelRay {
    /// Whether it presses.
    pub pressed: bool,
    /// The hand that holds it.
    pub hand: Option<Hand>,
    /// Where it meets a panel, in metres from its origin; written by the plugin.
    pub hit: Option<f32>,
}
