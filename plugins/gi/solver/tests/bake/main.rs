//! The parts of a bake.

#[path = "../common/mod.rs"]
mod common;

mod agreement;
mod direct;
mod layout;
mod passes;
mod saved;
mod scenes;
mod surfaces;
