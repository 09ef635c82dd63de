//! A gallery of three rooms to walk about in, on the desktop or with a headset: one program for both.
//! Direct light is Bevy's own; all light that walls give to each other is solved in a background thread
//! (or by a lighting server, `--server`), and follows the lantern that is carried about.
//!
//! `cargo run --example xr_gallery` uses the headset if there is one, `-- --xr off` never. F1 or the
//! controller's button for it shows what does what, M or the menu button opens the panel: on the screen,
//! or in the world, pressed by the rays of both hands. With a headset the left stick teleports (push it
//! ahead, aim, let go) and turns you; grips take the lantern and small things in hand. At a desk W, A,
//! S, D walk, the mouse looks, E takes in hand what is in the middle of the view.
//!
//! `--headless --out DIR` makes a tour without window and headset: pictures of all rooms, of the panel
//! and a teleport, and a stereo pair. `--help` says more.

#![allow(unreachable_pub, reason = "the modules read like a library's")]

mod args;
mod building;
mod exhibits;
mod grab;
mod hands;
#[path = "../common/headless.rs"]
#[expect(dead_code, reason = "shared with others, which use more of it")]
mod headless;
mod labels;
mod lamp;
mod looks;
mod moving;
mod plan;
#[path = "../common/program.rs"]
mod program;
mod rooms;
mod screenshot;
mod settings;
mod sky;
mod teleport;
mod textures;
mod tour;

use std::{process::ExitCode, sync::Arc};

use args::{Args, HELP, Server};
use bevy::prelude::*;
use farlight::{
    controls::UserFile,
    gi::{BackendFactory, ThreadBackend},
    prelude::*,
    remote::{RemoteBackend, RemoteSettings},
};

fn main() -> ExitCode {
    let args = Args::parse(std::env::args().skip(1));
    program::run("xr_gallery", args, |args| args.help, HELP, run)
}

fn run(args: Args) -> Result<(), String> {
    let light = light(&args)?;
    match &args.tour {
        Some(out) => tour::run(&args, light, out),
        None => show(&args, light),
    }
}

/// Who solves the indirect light.
fn light(args: &Args) -> Result<BackendFactory, String> {
    let remote = match &args.server {
        None => {
            return Ok(Arc::new(|settings: &GiSettings| {
                Box::new(ThreadBackend::new(settings.session()))
            }));
        }
        Some(Server::Invitation(text)) => {
            RemoteSettings::from_invitation(text).map_err(|e| format!("--server: {e}"))?
        }
        Some(Server::File(path)) => RemoteSettings::from_invite_file(path),
    };
    Ok(Arc::new(RemoteBackend::factory(remote.with_name("xr_gallery"))))
}

/// What the app is with and without a window or a headset.
fn build(app: &mut App, args: &Args, light: BackendFactory) {
    // A tour is the same wherever it is made: without what somebody has bound anew, or holds in hand.
    let tour = args.tour.is_some();
    let settings = GiSettings {
        texels_per_metre: args.texels as f32,
        page_size: 512,
        max_pages: 4,
        seed: args.seed,
        converged_paths: args.paths.unwrap_or(if tour { 512 } else { 4096 }),
        ..default()
    };
    let controls = ControlsPlugin {
        file: Some("config/gallery.controls.ron".into()),
        user_file: if tour { UserFile::Nowhere } else { UserFile::OfTheProgram },
        gamepads: !tour,
    };
    // The gallery's own section is the panel's first.
    app.register_type::<settings::Gallery>()
        .init_resource::<settings::Gallery>()
        .add_panel_resource::<settings::Gallery>("Gallery")
        .insert_resource(settings)
        .add_plugins(
            FarlightPlugins
                .set(GiPlugin::with_backend(move |settings| light(settings)))
                .set(controls),
        )
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::BLACK))
        .init_resource::<plan::Floor>()
        .init_resource::<looks::Adapted>()
        .add_plugins((exhibits::plugin, grab::plugin, hands::plugin, lamp::plugin, moving::plugin))
        .add_systems(PreStartup, sky::spawn)
        .add_systems(Startup, (rooms::spawn, labels::spawn, looks::spawn))
        .add_systems(
            Update,
            (
                settings::act,
                sky::update,
                (looks::open_eyes, looks::adapt, looks::smooth_edges).chain(),
            ),
        );
}

/// With the headset, or in a window.
fn show(args: &Args, light: BackendFactory) -> Result<(), String> {
    let mut app = App::new();
    let plugins =
        program::in_window("Farlight: gallery", args.size.unwrap_or((1280, 720)), default());
    let headset = FarlightXr::default().app_name("Farlight gallery").switched_by(std::env::args());
    app.add_plugins(headset.wrap(plugins));
    build(&mut app, args, light);
    app.add_plugins(screenshot::plugin);
    program::until_closed(app)
}
