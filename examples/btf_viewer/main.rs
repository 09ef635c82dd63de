//! Measured materials on objects: a sphere, a plane, draped cloth, a rabbit, a hippopotamus or any
//! glTF file, under one or five point lights, a sun, a spot light and environments.
//!
//! `cargo run --example btf_viewer` opens a window; the keys are on screen. What there is to choose
//! from, and how it begins, stands in `assets/config/btf_viewer.ron`, which is read again when it
//! changes. `--headless --out DIR` draws a turntable without a window; `--help` says more.

#![allow(unreachable_pub, reason = "the modules read like a library's")]

mod args;
mod camera;
mod config;
mod environment;
#[path = "../common/headless.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod headless;
mod hud;
mod lamps;
mod material;
mod object;
#[path = "../common/room/orbit.rs"]
mod orbit;
#[path = "../common/panel.rs"]
mod panel;
#[path = "../common/ring.rs"]
mod ring;
mod state;
mod tangents;
mod turntable;

use std::process::ExitCode;

use args::Args;
use bevy::{asset::UnapprovedPathMode, prelude::*};
use config::Viewer;
use farlight::{core::FarlightCorePlugin, prelude::*};
use state::{Config, Problems, Shown, Source};

fn main() -> ExitCode {
    let args = match Args::parse(std::env::args().skip(1)) {
        Ok(args) => args,
        Err(message) => {
            eprintln!("btf_viewer: {message}");
            return ExitCode::from(2);
        }
    };
    if args.help {
        print!("{}", args::HELP);
        return ExitCode::SUCCESS;
    }
    match run(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("btf_viewer: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: Args) -> Result<(), String> {
    let file = args.config.clone();
    let file = file.unwrap_or_else(|| state::assets().join("config/btf_viewer.ron"));
    let source = Source { file, args };
    let config = state::read(&source)?;
    let Args { headless, frames, size, .. } = source.args.clone();
    match headless {
        Some(out) => {
            let size = UVec2::from(size.unwrap_or((640, 480)));
            turntable::run(config, &out, frames, size, |app, config| {
                build(app, config, source);
                app.add_systems(PostStartup, smooth);
            })
        }
        None => window(config, source),
    }
}

/// Without a window nobody waits for a frame.
fn smooth(mut cameras: Query<&mut Msaa>) {
    cameras.iter_mut().for_each(|mut camera| *camera = Msaa::Sample4);
}

/// What the app does in a window and without.
fn build(app: &mut App, config: Viewer, source: Source) {
    app.insert_resource(Shown::start(&config))
        .insert_resource(Config(config))
        .insert_resource(source)
        .init_resource::<Problems>()
        .init_resource::<object::Stand>()
        .insert_resource(GlobalAmbientLight::NONE)
        .add_plugins((FarlightCorePlugin, BtfPlugin, IblPlugin, material::plugin))
        .add_systems(Startup, (camera::spawn, lamps::spawn, object::spawn))
        .add_systems(
            Update,
            (
                (object::choose, object::arrive, object::fit, object::place).chain(),
                lamps::hang,
                (environment::show, environment::watch).chain(),
                camera::tune,
            ),
        );
}

fn window(config: Viewer, source: Source) -> Result<(), String> {
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(AssetPlugin {
                file_path: state::assets().display().to_string(),
                // The person at the keyboard names files anywhere.
                unapproved_path_mode: UnapprovedPathMode::Allow,
                ..default()
            })
            .set(WindowPlugin {
                primary_window: Some(Window {
                    title: "Farlight: measured materials".into(),
                    resolution: config.window.into(),
                    ..default()
                }),
                ..default()
            }),
    );
    build(&mut app, config, source);
    app.add_systems(Startup, (hud::spawn, ring::spawn))
        .add_systems(PostStartup, camera::hang_canvas)
        .add_systems(
            Update,
            (
                state::watch,
                hud::keys,
                orbit::orbit,
                camera::fit_canvas,
                camera::screenshot,
                hud::show,
                ring::show,
            ),
        );
    match app.run() {
        AppExit::Success => Ok(()),
        AppExit::Error(code) => Err(format!("the app exited with code {code}")),
    }
}
