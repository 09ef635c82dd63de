//! What the environment's light is, and how it refines itself.

use std::ops::RangeInclusive;

use bevy::prelude::*;
use farlight_core::field::{Label, Logarithmic, Turn, Unit};
use farlight_environment::Method;

use crate::EnvironmentMap;

/// Lights that a map may become.
pub const LIGHTS: RangeInclusive<u32> = 1..=4096;
/// Lights a frame; Bevy draws ten directional lights in all.
pub const PER_FRAME: RangeInclusive<u32> = 1..=10;

/// The environment and how its light is refined. One an app; cameras take part with a
/// [`ProgressiveCamera`](crate::ProgressiveCamera).
#[derive(Resource, Clone, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone)]
pub struct ProgressiveLighting {
    /// Whether the lights shine. Off, the environment lights nothing by itself; whatever else the
    /// camera has (an `EnvironmentMapLight`) stays.
    pub enabled: bool,
    /// The environment; none is no light.
    pub environment: Option<Handle<EnvironmentMap>>,
    /// From the map's frame to the world. Turning is instant: the lights turn.
    #[reflect(@Turn)]
    pub rotation: Quat,
    /// Multiplies the map's values into cd/m².
    #[reflect(@0.01..=100_000.0_f32, @Logarithmic)]
    pub brightness: f32,
    /// Directional lights that stand for the whole map ([`LIGHTS`]). More are closer to the map and
    /// need more frames.
    #[reflect(@LIGHTS)]
    pub lights: u32,
    /// How many of them shine in a frame ([`PER_FRAME`]); fewer where the game's own directional
    /// lights need the places ([`EnvironmentStatus::per_frame`](crate::EnvironmentStatus::per_frame)).
    #[reflect(@PER_FRAME, @Label("Lights a frame"))]
    pub per_frame: u32,
    /// How lights are chosen.
    #[reflect(ignore)]
    pub method: Method,
    /// Another seed, other lights.
    pub seed: u64,
    /// Whether the lights cast shadows.
    pub shadows: bool,
    /// Metres from a camera up to which shadows are cast; nearer is sharper. They end at 75 to 100 % of
    /// it, for some lights nearer than for others. Scenes that are smaller lose nothing by a large
    /// value; cameras with a parallel projection have shadows over their whole depth.
    #[reflect(@1.0..=1000.0_f32, @Unit("m"))]
    pub shadow_distance: f32,
}

impl Default for ProgressiveLighting {
    fn default() -> Self {
        Self {
            enabled: true,
            environment: None,
            rotation: Quat::IDENTITY,
            brightness: 1.0,
            lights: 200,
            per_frame: 5,
            method: Method::default(),
            seed: 0,
            shadows: true,
            shadow_distance: 50.0,
        }
    }
}
