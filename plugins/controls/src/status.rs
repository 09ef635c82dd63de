//! What a game can show of its controls.

use std::path::PathBuf;

use bevy::prelude::*;
use farlight_bindings::{ActionInfo, Conflict};

use crate::GamepadReader;

/// What became of the bindings, and who reads gamepads.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct ControlsStatus {
    /// What is wrong with the files, each with its file and place; the last good bindings count.
    pub problems: Vec<String>,
    /// Inputs that do two things at once.
    pub conflicts: Vec<Conflict>,
    /// Actions that the game has added to the suite's.
    pub added: Vec<ActionInfo>,
    /// Who reads gamepads.
    pub gamepads: GamepadReader,
    /// Where the user's own changes are kept.
    pub user_file: Option<PathBuf>,
    /// How often the bindings have changed: whoever shows them looks at it.
    pub revision: u64,
}
