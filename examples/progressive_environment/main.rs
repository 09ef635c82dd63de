//! Environment light that refines itself: models and spheres of glossy to matte materials and a
//! measured cloth, lit by an environment map through directional lights, a few of them a frame.
//!
//! `cargo run --example progressive_environment` opens a window; the keys are on screen. Small dots on
//! the sky are all lights, large ones those of this frame; the ring shows how far the picture is.
//! `--headless --out DIR` writes pictures without a window; `--help` says more.

#![allow(unreachable_pub, reason = "the modules read like a library's")]

mod args;
mod flat_map;
#[path = "../common/headless.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod headless;
mod hud;
mod keys;
#[path = "../common/room/orbit.rs"]
mod orbit;
#[path = "../common/panel.rs"]
mod panel;
mod pictures;
#[path = "../common/program.rs"]
mod program;
#[path = "../common/ring.rs"]
mod ring;
mod scene;
mod shown;
mod sway;

use std::process::ExitCode;

use args::Args;
use bevy::{asset::UnapprovedPathMode, prelude::*};
use farlight::{btf::BtfPlugin, core::FarlightCorePlugin, ibl::IblPlugin};
use shown::Shown;

fn main() -> ExitCode {
    let args = Args::parse(std::env::args().skip(1));
    program::run(
        "progressive_environment",
        args,
        |args| args.help,
        args::HELP,
        |args| match &args.out {
            Some(out) => pictures::run(&args, out),
            None => window(&args),
        },
    )
}

/// What the app does in a window and without.
fn build(app: &mut App, shown: Shown) {
    app.insert_resource(shown)
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::srgb_u8(25, 25, 30)))
        .add_plugins((FarlightCorePlugin, BtfPlugin, IblPlugin))
        .add_systems(Startup, scene::spawn)
        .add_systems(Update, (shown::apply, sway::sway).chain());
}

fn window(args: &Args) -> Result<(), String> {
    let mut app = App::new();
    app.add_plugins(
        // The person at the keyboard names files anywhere.
        program::in_window(
            "Farlight: environment light that refines itself",
            args.size.unwrap_or((1280, 720)),
            UnapprovedPathMode::Allow,
        ),
    );
    build(&mut app, args.shown.clone());
    hud_systems(&mut app);
    app.add_systems(Update, (keys::keys, orbit::orbit).before(shown::apply));
    program::until_closed(app)
}

/// Text, ring and map.
fn hud_systems(app: &mut App) {
    app.add_systems(Startup, (hud::spawn, ring::spawn, flat_map::spawn))
        .add_systems(Update, (hud::show, ring::show, flat_map::paint, flat_map::mark));
}
