//! Every action live, for the device in hand: an object, a light and a camera that follow what is
//! pressed, and a list of all actions with their inputs that lights up where one is used.
//!
//! `cargo run --example controls_playground` opens a window. Take a gamepad, touch the screen, or move
//! the mouse: the list follows. `--headless --out DIR` writes a picture for each kind of device; `--help`
//! says more.

#![allow(unreachable_pub, reason = "the modules read like a library's")]

mod args;
#[path = "../common/headless.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod headless;
mod list;
mod pictures;
#[path = "../common/program.rs"]
mod program;
#[path = "../common/recording.rs"]
mod recording;
mod scene;
mod script;

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use args::Args;
use bevy::{asset::UnapprovedPathMode, prelude::*};
use farlight::controls::{
    ActionRecorder, ActionReplay, Controls, ControlsPlugin, ReplayPace, UserFile,
    actions::{Quit, Reset},
};
use farlight_bindings::Recording;

fn main() -> ExitCode {
    let args = Args::parse(std::env::args().skip(1));
    program::run(
        "controls_playground",
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
fn build(app: &mut App, controls: ControlsPlugin) {
    app.add_plugins(controls)
        .init_resource::<scene::Shown>()
        .insert_resource(ClearColor(Color::srgb_u8(20, 22, 27)))
        .add_systems(Startup, (scene::spawn, list::spawn))
        .add_systems(Update, (reset, scene::act, scene::apply).chain())
        .add_systems(Update, (list::fill, list::light_up).chain());
}

/// As at the start.
fn reset(controls: Controls, mut shown: ResMut<scene::Shown>) {
    if controls.started::<Reset>() {
        *shown = scene::Shown::default();
    }
}

/// Writes a recording.
fn save(path: &Path, recording: &Recording) -> Result<(), String> {
    std::fs::write(path, recording.to_string()).map_err(|e| format!("{}: {e}", path.display()))
}

/// Where the recording goes.
#[derive(Resource)]
struct RecordTo(PathBuf);

fn window(args: &Args) -> Result<(), String> {
    let replay = args.replay.as_deref().map(recording::read).transpose()?;
    let mut app = App::new();
    app.add_plugins(program::in_window("Controls", args.size, UnapprovedPathMode::Allow));
    build(&mut app, ControlsPlugin { file: args.config()?, ..default() });
    app.add_systems(Update, quit);
    if let Some(replay) = replay {
        app.world_mut().resource_mut::<ActionReplay>().play(replay, ReplayPace::Time);
    }
    if let Some(path) = &args.record {
        app.insert_resource(RecordTo(path.clone()));
        app.world_mut().resource_mut::<ActionRecorder>().start();
        app.add_systems(Last, record);
    }
    program::until_closed(app)
}

fn quit(controls: Controls, mut exit: MessageWriter<AppExit>) {
    if controls.started::<Quit>() {
        exit.write(AppExit::Success);
    }
}

/// Writes the recording when the program ends.
fn record(
    mut exits: MessageReader<AppExit>,
    mut recorder: ResMut<ActionRecorder>,
    to: Res<RecordTo>,
) {
    if exits.read().count() > 0
        && let Some(recording) = recorder.stop()
        && let Err(problem) = save(&to.0, &recording)
    {
        error!("{problem}");
    }
}

/// Controls that read and keep nothing of the machine's user.
fn quiet_controls(file: Option<String>) -> ControlsPlugin {
    ControlsPlugin { file, user_file: UserFile::Nowhere, gamepads: false }
}
