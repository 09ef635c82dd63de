//! Shows what `farlight bake` made: a manifest, its scene, its lightmaps, volumes and lights.
//!
//! `cargo run --example baked -- room/room.baked.ron` opens a window; without a name it shows the study
//! of `assets/baked`. Keys: 1 to 8 show a scenario, W A S D Q E move, mouse drag or arrow keys look
//! around, + and - change the exposure, B switches bicubic filtering.
//! `--headless --out DIR` writes a picture of each scenario without a window; `--help` says more.

#![allow(unreachable_pub, reason = "the modules read like a library's")]

mod args;
#[path = "../common/headless.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod headless;
mod keys;
#[path = "../common/panel.rs"]
mod panel;
#[path = "../common/program.rs"]
mod program;
mod view;
#[path = "../common/walk.rs"]
mod walk;

use std::{path::Path, process::ExitCode, time::Duration};

use args::Args;
use bevy::{asset::UnapprovedPathMode, prelude::*};
use farlight::prelude::*;
use headless::Headless;

fn main() -> ExitCode {
    let args = Args::parse(std::env::args().skip(1));
    program::run(
        "baked",
        args,
        |args| args.help,
        args::HELP,
        |args| match &args.out {
            Some(out) => pictures(&args, out),
            None => window(&args),
        },
    )
}

/// What the app does in a window and without.
fn build(app: &mut App, args: &Args) {
    app.add_plugins(BakedPlugin::default())
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(args.clone())
        .add_systems(Startup, view::spawn)
        .add_systems(Update, (view::place_camera, view::paint_sky).chain());
}

fn window(args: &Args) -> Result<(), String> {
    let mut app = App::new();
    app.add_plugins(
        // The person at the keyboard names files anywhere.
        program::in_window("Farlight: baked light", args.size, UnapprovedPathMode::Allow),
    );
    build(&mut app, args);
    app.add_systems(Startup, keys::spawn)
        .add_systems(Update, (walk::walk, keys::keys, keys::show).chain());
    program::until_closed(app)
}

/// A picture of each scenario, and what the status says.
fn pictures(args: &Args, out: &Path) -> Result<(), String> {
    let size = UVec2::from(args.size);
    let mut headless = Headless::new(size, &program::assets(), |app| build(app, args))?;
    headless.set_frame_time(Duration::from_millis(16));
    let patience = Duration::from_secs(120);
    headless.update_until("the manifest, its textures and its scene", patience, |world| {
        let status = world.resource::<BakedStatus>();
        status.roots.iter().any(|root| root.state != BakedState::Loading)
    })?;
    let status = headless.app.world().resource::<BakedStatus>().clone();
    for root in &status.roots {
        if let BakedState::Failed { reason } = &root.state {
            return Err(reason.to_string());
        }
        println!(
            "{} meshes are lit, {} probe volumes, {} lights, {:.1} MB of textures",
            root.receivers,
            root.volumes,
            root.lights,
            root.texture_bytes as f64 / 1e6
        );
        root.left_out.iter().for_each(|left| println!("left out: {}", left.reason));
    }
    let scenarios: Vec<_> = match &args.scenario {
        Some(name) => vec![name.clone()],
        None => status.roots[0].scenarios.iter().map(|(name, _)| name.clone()).collect(),
    };
    for name in scenarios {
        let world = headless.app.world_mut();
        for mut lighting in world.query::<&mut BakedLighting>().iter_mut(world) {
            lighting.scenarios.show(name.clone());
        }
        for _ in 0..3 {
            headless.update()?;
        }
        let file = out.join(format!("{}.png", name.replace(['/', '\\', ' '], "-")));
        headless.capture_still()?.save(&file)?;
        println!("wrote {}", file.display());
    }
    Ok(())
}
