//! Panels in rendered pictures, steered by mouse, keys, gamepad and rays.

#[path = "../support/mod.rs"]
mod support;

#[path = "../support/clock.rs"]
mod clock;
mod covered;
mod fits;
mod focus;
#[path = "../support/game.rs"]
mod game;
mod in_world;
mod network;
mod on_screen;
mod rebind;
mod sharp;
mod stage;
mod still;
mod suite;
