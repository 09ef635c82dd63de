//! The parts of a bake.

#[path = "../common/mod.rs"]
mod common;

mod layout;
mod saved;
mod scenes;
