//! What a game can show of it.

use std::borrow::Cow;

use bevy::prelude::*;

/// What becomes of the environment.
#[derive(Resource, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone)]
pub struct EnvironmentStatus {
    /// Where it is.
    pub state: EnvironmentState,
    /// Lights that stand for the map.
    pub lights: u32,
    /// Lights that shine in a frame.
    pub per_frame: u32,
    /// Whether fewer shine than asked for, since the game's own directional lights have the places.
    pub crowded_out: bool,
}

/// Where the environment is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Default, Debug, Clone)]
pub enum EnvironmentState {
    /// There is none.
    #[default]
    None,
    /// The map is being read.
    Loading,
    /// Its lights are being chosen; those before shine on.
    Choosing,
    /// It shines.
    Ready,
    /// It can't be used; in words for the game's author.
    Failed(Cow<'static, str>),
}
