//! The room of the demos: a bright room, a dark room and a doorway between them. The lamp in the
//! bright room moves, and the dark room follows. Where the indirect light is solved is up to the
//! example; the room only knows a [`BackendFactory`].
//!
//! What is drawn and how it moves is in `scene`, `motion`, `orbit` and `hud`; it knows nothing of a
//! solver. `measured` holds the runs without a window: it looks at what the backend is told and
//! answers, and computes references with the solver's path tracer after the live part is over.

#![allow(unreachable_pub, reason = "the modules read like a library's")]

pub mod args;
mod hud;
mod measured;
mod motion;
mod orbit;
#[path = "../program.rs"]
mod program;
mod scene;

use std::process::ExitCode;

use args::{Args, Mode};
use bevy::prelude::*;
use farlight::{
    gi::{BackendFactory, LightingBackend},
    prelude::*,
};

pub use measured::Counting;

/// An example in this room.
pub struct Program {
    /// Its name on the command line.
    pub name: &'static str,
    /// The window's title.
    pub title: &'static str,
    /// Who solves the indirect light, in a few lines of `--help`.
    pub about: &'static str,
    /// Whether it takes `--server` and `--server-file`.
    pub takes_server: bool,
    /// Who solves the indirect light.
    pub light: fn(&Args) -> Result<BackendFactory, String>,
}

impl Program {
    /// Does what the command line says.
    pub fn run(&self) -> ExitCode {
        let args = Args::parse(std::env::args().skip(1), self.takes_server);
        let help = args::help(self.name, self.about, self.takes_server);
        program::run(
            self.name,
            args,
            |args| args.mode == Mode::Help,
            &help,
            |args| {
                let light = (self.light)(&args)?;
                match &args.mode {
                    // Its help is printed.
                    Mode::Help => Ok(()),
                    Mode::Window => window(&args, light, self.title),
                    Mode::Headless { out, frames } => measured::run(&args, light, out, *frames),
                    Mode::Soak(time) => measured::soak(&args, light, *time),
                }
            },
        )
    }
}

/// What the app does in a window and without.
fn build<L>(app: &mut App, args: &Args, light: L)
where
    L: Fn(&GiSettings) -> Box<dyn LightingBackend> + Send + Sync + 'static,
{
    let settings =
        GiSettings { page_size: args.lightmap, max_pages: 1, seed: args.seed, ..default() };
    app.insert_resource(settings)
        .add_plugins(FarlightPlugins.set(GiPlugin::with_backend(light)))
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::srgb(0.012, 0.013, 0.016)))
        .insert_resource(scene::shadow_map())
        .add_systems(Startup, scene::spawn)
        .add_systems(Update, motion::travel);
}

fn window(args: &Args, light: BackendFactory, title: &str) -> Result<(), String> {
    let mut app = App::new();
    app.add_plugins(program::in_window(title, args.window, default()));
    build(&mut app, args, move |settings| light(settings));
    app.add_systems(Startup, hud::spawn)
        .add_systems(PostStartup, scene::smooth_edges)
        .add_systems(Update, (orbit::orbit, hud::keys, hud::show));
    program::until_closed(app)
}
