//! What a game switches at run time.

use bevy::prelude::*;
use farlight_core::field::Label;

/// Switches of the indirect light.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone)]
pub struct GiControl {
    /// Whether indirect light is shown. Off writes black into the lightmaps and sets the volumes'
    /// intensity to 0 within one frame; solving goes on, so that on is as quick. No entity changes.
    pub enabled: bool,
}

impl Default for GiControl {
    fn default() -> Self {
        Self { enabled: true }
    }
}

/// What cameras show, for looking at the lighting itself.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Resource, Default, Debug, Clone)]
#[reflect(@Label("Cameras show"))]
pub enum GiView {
    /// Everything.
    #[default]
    Full,
    /// Without indirect light, as with [`GiControl::enabled`] off.
    DirectOnly,
    /// The lightmaps alone, on white: cameras see white copies of the lightmapped meshes on a
    /// render layer in which there is no light ([`GiView::LAYER`]).
    LightmapOnly,
}

impl GiView {
    /// The render layer of the white copies.
    pub const LAYER: usize = 31;

    /// The next one, for a key that goes round.
    #[must_use]
    pub fn next(self) -> Self {
        match self {
            Self::Full => Self::DirectOnly,
            Self::DirectOnly => Self::LightmapOnly,
            Self::LightmapOnly => Self::Full,
        }
    }
}
