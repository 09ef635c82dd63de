//! Baked lighting in Bevy: what a manifest says is what is drawn.
//!
//! Pictures need a Vulkan device; Mesa's lavapipe will do.

mod against_live;
mod blending;
mod files;
mod folder;
mod gi;
mod life;
mod lights;
mod pictures;
mod reasons;
mod stage;
#[path = "../support/mod.rs"]
mod support;
