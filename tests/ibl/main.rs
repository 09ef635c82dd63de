//! Environment light in rendered pictures.

#[path = "../support/mod.rs"]
mod support;

mod backdrop;
mod refine;
mod screenshot;
mod stage;
