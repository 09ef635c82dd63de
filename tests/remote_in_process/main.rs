//! A game and a lighting server in one process: over a simulated network in virtual time, and with
//! Bevy and threads in real time.

mod app;
#[path = "../support/clock.rs"]
mod clock;
mod faults;
#[path = "../support/game.rs"]
mod game;
mod outages;
mod picture;
mod scene;
mod stage;
mod still;
