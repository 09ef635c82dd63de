//! Panels in rendered pictures, steered by mouse, keys, gamepad and rays.

#[path = "../support/mod.rs"]
mod support;

mod focus;
mod in_world;
mod on_screen;
mod sharp;
mod stage;
mod still;
mod suite;
