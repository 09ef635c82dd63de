//! How panels look and where they are.

use bevy::prelude::*;
use farlight_core::field::{Label, Unit};

use crate::PanelPlace;

/// How panels look and where they are.
#[derive(Resource, Clone, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct PanelSettings {
    /// Where panels are: on the screen, in the world, or in the world while somebody wears a headset.
    pub place: PanelPlace,
    /// Size of text and widgets; 1 is as the window's scale factor says.
    #[reflect(@0.6..=2.5_f32)]
    pub scale: f32,
    /// How much of the picture a panel hides.
    #[reflect(@0.5..=1.0_f32, @Unit("%"))]
    pub opacity: f32,
    /// Whether the screen says at the start which inputs open the menu and help.
    pub hint: bool,
    /// How far away a panel in the world is.
    #[reflect(@0.4..=4.0_f32, @Unit("m"))]
    pub distance: f32,
    /// How wide a panel in the world is.
    #[reflect(@0.3..=3.0_f32, @Unit("m"))]
    pub width: f32,
    /// How quickly a panel in the world comes after: about this many times a second it could do
    /// the whole way.
    #[reflect(@0.2..=10.0_f32, @Unit("/s"))]
    pub follow: f32,
    /// How much of a panel in the world is seen through what is nearer than it: nothing of it is hidden
    /// at 100 %, and everything at 0 %.
    #[reflect(@0.0..=1.0_f32, @Unit("%"), @Label("Seen through things"))]
    pub through: f32,
    /// How long to look at a control in the world until it is pressed; 0 is never.
    #[reflect(@0.0..=3.0_f32, @Unit("s"), @Label("Press by gaze after"))]
    pub gaze_dwell: f32,
}

impl Default for PanelSettings {
    fn default() -> Self {
        Self {
            place: PanelPlace::Auto,
            scale: 1.0,
            opacity: 0.94,
            hint: true,
            distance: 1.25,
            width: 0.85,
            follow: 1.5,
            through: 0.9,
            gaze_dwell: 0.0,
        }
    }
}
