//! When actions are heard.

use bevy::prelude::*;

/// The context of actions of the scene.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct SceneContext;

/// The context of actions that are always heard.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct GlobalContext;

/// The context of actions of an open panel. While it is active, what it uses is taken from the others.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct PanelContext;
