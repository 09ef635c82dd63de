//! Headsets, without one: both eyes are fed by hand.

#[path = "../support/mod.rs"]
mod support;

mod actions;
mod culling;
mod desktop;
mod follow;
mod parallax;
mod pictures;
mod stage;
mod trigger;
