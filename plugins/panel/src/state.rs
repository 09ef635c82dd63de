//! What is open, and where.

use bevy::prelude::*;

/// Where panels are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Default, Clone, PartialEq)]
pub enum PanelPlace {
    /// In the world while there is a [`PanelViewer`], on the screen otherwise.
    #[default]
    Auto,
    /// On the screen.
    Screen,
    /// On a quad in the world, in front of the viewer.
    World,
}

/// What is open. The actions `Menu`, `Help` and `PanelBack` change it.
/// ([`PanelSettings`](crate::PanelSettings) say where.)
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct PanelState {
    /// The menu with the settings.
    pub menu: bool,
    /// What does what on the device in hand.
    pub help: bool,
    /// The section to unfold, by its title; all others are folded. Taken when the menu is drawn.
    pub unfold: Option<&'static str>,
}

/// The camera on whose picture panels are drawn. Without one it is the camera that draws into a
/// window last. Pictures that go elsewhere have panels only where this asks for them.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct PanelCamera;

/// A camera that shows panels in the world beside the one of the screen: an eye of a headset. It never
/// shows panels of the screen.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct PanelEye;

/// The head of somebody who wears a headset: panels in the world follow it. Without one they follow
/// the camera.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
#[require(Transform)]
pub struct PanelViewer;

/// A line that is shown for a few seconds: what an action did, what went wrong.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct Notification {
    /// What to say.
    pub text: String,
    /// Whether it is about a failure.
    pub problem: bool,
}

impl Notification {
    /// Something happened.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), problem: false }
    }

    /// Something went wrong.
    pub fn problem(text: impl Into<String>) -> Self {
        Self { text: text.into(), problem: true }
    }
}
