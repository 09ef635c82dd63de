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
mod pictures;
#[path = "../common/program.rs"]
mod program;
mod scene;
#[path = "../common/walk.rs"]
mod walk;

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

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

/// The folder of all asset files.
fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets")
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
    app.add_plugins(
        DefaultPlugins
            .set(AssetPlugin { file_path: assets().display().to_string(), ..default() })
            .set(WindowPlugin {
                primary_window: Some(Window {
                    title: "Farlight: a day in a room".into(),
                    resolution: args.size.into(),
                    ..default()
                }),
                ..default()
            }),
    );
    build(&mut app);
    app.add_systems(Startup, hud::spawn)
        .add_systems(Update, (walk::walk, hud::keys, hud::drag, hud::show).before(day::pass));
    match app.run() {
        AppExit::Success => Ok(()),
        AppExit::Error(code) => Err(format!("the app exited with code {code}")),
    }
}
