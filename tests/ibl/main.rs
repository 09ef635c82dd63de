//! Environment light in rendered pictures.

#[path = "../support/mod.rs"]
mod support;

mod atmosphere;
mod backdrop;
mod cameras;
mod changes;
mod motion;
mod own_lights;
mod refine;
mod screenshot;
mod shadows;
mod stage;
mod status;
