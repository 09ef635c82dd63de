//! What panels take for themselves.

use bevy::prelude::*;

/// Inputs that a panel has taken: actions don't hear them. Panels set it before
/// [`ControlsSystems::Sample`](crate::ControlsSystems::Sample).
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InputCapture {
    /// A text is being written: keys are letters. (Esc and function keys still act.)
    pub keyboard: bool,
    /// The pointer is on a panel: mouse buttons, drags and the wheel are the panel's, and so are fingers.
    pub pointer: bool,
    /// Rays of hands are on a panel: their triggers are the panel's. Left, right.
    pub hands: [bool; 2],
    /// A panel is open and is steered by keys, gamepad or controllers:
    /// [`PanelContext`](crate::PanelContext) is active.
    pub panel: bool,
}
