//! Whether there is a headset, and where its space stands.

use bevy::prelude::*;

/// Whether there is a headset.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub enum XrStatus {
    /// The app is on the desktop, for this reason.
    Unavailable(String),
    /// The app has not asked yet.
    #[default]
    Unknown,
    /// There is one, but it shows nothing of the app now.
    Idle,
    /// It shows the app.
    Running,
}

/// The room of the person in the world: its floor's middle, turn and scale. A scale of 2 makes the
/// person twice as large, and the world half.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct XrRig(pub Transform);

/// Puts the person back: to the rig's middle, looking along its -z.
#[derive(Message, Clone, Copy, Debug, Default)]
pub struct Recentre;
