//! Measured materials on objects: a sphere, a plane, draped cloth, a rabbit, a hippopotamus or any
//! glTF file, under one or five point lights, a sun, a spot light and environments.
//!
//! `cargo run --example btf_viewer` opens a window, and is in a headset if there is one; F1 shows what
//! keys, gamepad or controllers do. What there is to choose
//! from, and how it begins, stands in `assets/config/btf_viewer.ron`, which is read again when it
//! changes. `--headless --out DIR` draws a turntable without a window; `--help` says more.

#![allow(unreachable_pub, reason = "the modules read like a library's")]

mod actions;
mod args;
mod camera;
mod config;
mod environment;
mod grab;
mod hands;
#[path = "../common/headless.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod headless;
mod headset;
mod lamps;
mod material;
mod object;
mod pictures;
#[path = "../common/program.rs"]
mod program;
#[path = "../common/recording.rs"]
mod recording;
mod replay;
#[path = "../common/ring.rs"]
mod ring;
mod screenshot;
mod sections;
mod shown;
mod stage;
mod state;
mod status;
mod tangents;
mod turntable;
mod view;
mod viewpoint;

use std::process::ExitCode;

use args::Args;
use bevy::{app::PluginGroupBuilder, asset::UnapprovedPathMode, prelude::*};
use config::{HeadsetMode, Viewer};
use farlight::{
    controls::{ActionReplay, ReplayPace, UserFile, bindings::Recording},
    prelude::*,
    remote::RemotePlugin,
    xr::{XrPlugin, XrStatus},
};
use shown::Shown;
use stage::Stage;
use state::{Config, Problems, Source};

fn main() -> ExitCode {
    let args = Args::parse(std::env::args().skip(1));
    program::run("btf_viewer", args, |args| args.help, args::HELP, run)
}

fn run(args: Args) -> Result<(), String> {
    let file = args.config.clone();
    let file = file.unwrap_or_else(|| program::assets().join("config/btf_viewer.ron"));
    let source = Source { file, args };
    let config = state::read(&source)?;
    let Args { headless, frames, size, ui, replay, .. } = source.args.clone();
    let recording = replay.map(|file| replay::read(&file)).transpose()?;
    let Some(out) = headless else { return window(config, source, recording) };
    let size = UVec2::from(size.unwrap_or((640, 480)));
    let program = |app: &mut App, config: Viewer, source: Source| {
        app.add_plugins(XrPlugin::default());
        let people = config.clone();
        build(app, config, source);
        // The person's own bindings and gamepads make no difference.
        let controls =
            ControlsPlugin { user_file: UserFile::Nowhere, gamepads: false, ..default() };
        interact(app, &people, controls);
    };
    if let Some(recording) = recording {
        let program = |app: &mut App, config| program(app, config, source);
        return replay::run(config, recording, &out, size, program);
    }
    if ui {
        return pictures::run(config, &out, size, |app, config| program(app, config, source));
    }
    turntable::run(config, &out, frames, size, |app, config| {
        build(app, config, source);
        app.add_plugins(materials().disable::<ControlsPlugin>().disable::<PanelPlugin>())
            .add_systems(PostStartup, smooth);
    })
}

/// Without a window nobody waits for a frame.
fn smooth(mut cameras: Query<&mut Msaa>) {
    cameras.iter_mut().for_each(|mut camera| *camera = Msaa::Sample4);
}

/// What the app does in a window and without.
fn build(app: &mut App, config: Viewer, source: Source) {
    app.insert_resource(Shown::start(&config))
        .insert_resource(Stage::new(&config, false))
        .insert_resource(Config(config))
        .insert_resource(source)
        .init_resource::<Problems>()
        .init_resource::<object::Form>()
        .init_resource::<environment::Written>()
        .insert_resource(GlobalAmbientLight::NONE)
        .add_plugins(material::plugin)
        .add_systems(Startup, (camera::spawn, lamps::spawn, object::spawn))
        .add_systems(
            Update,
            (
                (object::choose, object::arrive, object::fit, object::place).chain(),
                lamps::hang,
                (environment::adopt, environment::show, environment::watch).chain(),
                camera::tune,
            )
                .in_set(Show),
        );
}

/// Actions have changed what is shown; now it is shown.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Show;

/// The suite's plugins that show materials.
fn materials() -> PluginGroupBuilder {
    FarlightPlugins.build().disable::<GiPlugin>().disable::<RemotePlugin>()
}

/// What people use: actions, panel, headset.
fn interact(app: &mut App, config: &Viewer, controls: ControlsPlugin) {
    let file = Some(config.controls.clone()).filter(|file| !file.is_empty());
    app.add_plugins(materials().set(ControlsPlugin { file, ..controls }))
        .add_plugins((headset::plugin, sections::plugin))
        .add_message::<view::ResetView>()
        .add_systems(Startup, (status::spawn, ring::spawn, hands::spawn_marker))
        .add_systems(PostStartup, camera::hang_canvas)
        .add_systems(
            Update,
            (
                (
                    (state::watch, stage::set, actions::act).chain(),
                    (view::look, view::reset, view::move_room).chain(),
                    (hands::grab, hands::teleport).chain(),
                )
                    .chain()
                    .before(Show),
                (camera::fit_canvas, screenshot::take, status::show, status::make_room, ring::show)
                    .after(Show),
            ),
        );
}

fn window(config: Viewer, source: Source, recording: Option<Recording>) -> Result<(), String> {
    let mut app = App::new();
    let xr = FarlightXr::default()
        .app_name("Farlight: measured materials")
        .resolution_scale(config.xr.resolution_scale);
    let xr = if config.xr.mode == HeadsetMode::Off { xr.disabled() } else { xr };
    app.add_plugins(xr.wrap(
        // The person at the keyboard names files anywhere.
        program::in_window(
            "Farlight: measured materials",
            config.window,
            UnapprovedPathMode::Allow,
        ),
    ));
    if config.xr.mode == HeadsetMode::On
        && let Some(XrStatus::Unavailable(reason)) = app.world().get_resource()
    {
        return Err(format!("no headset: {reason}"));
    }
    let people = config.clone();
    build(&mut app, config, source);
    interact(&mut app, &people, ControlsPlugin::default());
    if let Some(recording) = recording {
        app.world_mut().resource_mut::<ActionReplay>().play(recording, ReplayPace::Time);
    }
    program::until_closed(app)
}
