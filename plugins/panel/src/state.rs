//! What is open, and where.

use bevy::prelude::*;

/// Where panels are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
pub enum PanelPlace {
    /// On the screen.
    #[default]
    Screen,
    /// On a quad in the world, in front of the viewer.
    World,
}

/// What is open. The actions `Menu`, `Help` and `PanelBack` change it.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct PanelState {
    /// The menu with the settings.
    pub menu: bool,
    /// What does what on the device in hand.
    pub help: bool,
    /// Where.
    pub place: PanelPlace,
}

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
