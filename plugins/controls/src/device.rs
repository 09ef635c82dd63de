//! The device in hand.

use bevy::prelude::*;
use farlight_bindings::Device;

/// The device that was used last; help is about it.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct ActiveDevice {
    /// Its kind.
    pub device: Device,
    /// What it calls itself, if it does.
    pub name: Option<String>,
}
