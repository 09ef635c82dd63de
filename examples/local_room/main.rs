//! A bright room, a dark room and a doorway between them. The lamp in the bright room moves, and the
//! dark room follows: its light is indirect, solved in a background thread and streamed into a
//! lightmap. The ball that passes through the doorway is lit by probes.
//!
//! `cargo run --example local_room` opens a window. Keys: I indirect light on and off, L lightmap
//! alone, Space stops the lamp, B stops the ball, + and - change the lamp's speed, mouse drag or
//! arrow keys turn the camera, the wheel comes closer, H hides the text.
//!
//! `--headless --out DIR` measures and writes pictures without a window, `--soak SECONDS` watches
//! memory; `--help` says more.

#![allow(unreachable_pub, reason = "the modules read like a library's")]

mod args;
mod compare;
#[path = "../common/headless.rs"]
#[expect(dead_code, reason = "shared with the tests, which use more of it")]
mod headless;
mod hud;
mod live;
mod measure;
mod motion;
mod orbit;
mod record;
mod reference;
mod report;
mod run;
mod scene;
mod soak;
mod stats;

use std::{path::Path, process::ExitCode};

use args::{Args, Mode};
use bevy::prelude::*;
use farlight::{gi::ThreadBackend, prelude::*};
use record::Log;

#[global_allocator]
static ALLOCATOR: soak::Counting = soak::Counting;

fn main() -> ExitCode {
    let args = match Args::parse(std::env::args().skip(1)) {
        Ok(args) => args,
        Err(message) => {
            eprintln!("local_room: {message}");
            return ExitCode::from(2);
        }
    };
    let result = match &args.mode {
        Mode::Help => {
            print!("{}", args::HELP);
            Ok(())
        }
        Mode::Window => window(&args),
        Mode::Headless { out, frames } => run::run(&args, out, *frames),
        Mode::Soak(time) => soak::soak(&args, *time),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("local_room: {message}");
            ExitCode::FAILURE
        }
    }
}

/// The assets folder of the repository.
fn assets() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets")
}

/// What the app does in a window and without. With a log, what goes to and comes from the solver is
/// recorded.
fn build(app: &mut App, args: &Args, log: Option<Log>) {
    let edge = args.lightmap;
    let settings = GiSettings { page_size: edge, max_pages: 1, seed: args.seed, ..default() };
    let gi = match log {
        None => GiPlugin::default(),
        Some(log) => GiPlugin::with_backend(move |settings| {
            Box::new(log.record(Box::new(ThreadBackend::new(settings.session())), edge))
        }),
    };
    app.insert_resource(settings)
        .add_plugins(gi)
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::srgb(0.012, 0.013, 0.016)))
        .insert_resource(scene::shadow_map())
        .add_systems(Startup, scene::spawn)
        .add_systems(Update, motion::travel);
}

fn window(args: &Args) -> Result<(), String> {
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(AssetPlugin { file_path: assets().display().to_string(), ..default() })
            .set(WindowPlugin {
                primary_window: Some(Window {
                    title: "Farlight: local room".into(),
                    resolution: (1280, 720).into(),
                    ..default()
                }),
                ..default()
            }),
    );
    build(&mut app, args, None);
    app.add_systems(Startup, hud::spawn).add_systems(Update, (orbit::orbit, hud::keys, hud::show));
    match app.run() {
        AppExit::Success => Ok(()),
        AppExit::Error(code) => Err(format!("the app exited with code {code}")),
    }
}
