//! Environment light in rendered pictures.

#[path = "../support/mod.rs"]
mod support;

mod refine;
mod stage;
