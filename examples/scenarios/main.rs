//! A day in a room: baked scenarios (morning, noon, evening, and a lamp alone) blended at run time, the
//! camera's exposure with them. The ball is lit by probes that are blended too.
//!
//! `cargo run --example scenarios` opens a window. Keys: Space stops time, the bar below or , and . set
//! it, L switches the lamp (on, off, by itself), W A S D Q E and mouse drag or arrow keys move the
//! camera, H hides the text. `--headless --out DIR` writes pictures of the day without a window;
//! `--help` says more.

#![allow(unreachable_pub, reason = "the modules read like a library's")]

mod args;
mod day;
#[path = "../common/headless.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod headless;
mod hud;
#[path = "../common/panel.rs"]
mod panel;
mod pictures;
#[path = "../common/program.rs"]
mod program;
mod scene;
#[path = "../common/walk.rs"]
mod walk;

use std::process::ExitCode;

use args::Args;
use bevy::prelude::*;
use day::Day;
use farlight::prelude::*;

fn main() -> ExitCode {
    let args = Args::parse(std::env::args().skip(1));
    program::run(
        "scenarios",
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
fn build(app: &mut App) {
    app.add_plugins(BakedPlugin::default())
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::BLACK))
        .init_resource::<Day>()
        .add_systems(Startup, scene::spawn)
        .add_systems(Update, (day::pass, scene::light, scene::expose, scene::roll).chain());
}

fn window(args: &Args) -> Result<(), String> {
    let mut app = App::new();
    app.add_plugins(program::in_window("Farlight: a day in a room", args.size, default()));
    build(&mut app);
    app.add_systems(Startup, hud::spawn)
        .add_systems(Update, (walk::walk, hud::keys, hud::drag, hud::show).before(day::pass));
    program::until_closed(app)
}
