//! `cargo xtask demo`: the room with global illumination, from a fresh clone to pictures.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::args::Args;
use crate::lighting_server::LightingServer;
use crate::setup::{self, Purpose};
use crate::{Failure, environment, process};

/// The example that asks a lighting server, and the server's program.
const REMOTE: &str = "remote_room";
const SERVER: &str = "farlight";
/// The example that solves the light in its own process.
const LOCAL: &str = "local_room";

pub(crate) const HELP: &str = "\
cargo xtask demo [--local] [--no-install] [-- OPTIONS OF THE DEMO]
cargo xtask demo --headless --out DIR [--frames N] [--size WxH] [--local] [--no-install]

Looks for missing system packages, builds the command `farlight` and the example `remote_room`, starts
`farlight serve` as a process of its own and the example as another: a bright and a dark room, a
doorway between them, and a light that moves. The game sends the scene over loopback and gets its
light back; the server stops when the game does. In a window the keys are on screen.

  --local        no server: the example `local_room`, which solves in a thread of its own
  --headless     render without a window; writes direct-only.png, indirect.png, reference.png and
                 report.json, and fails if no update of the light arrived or the pictures are black
  --out DIR      where to (with --headless; default: demo/ in the build folder)
  --frames N     how many frames to render (with --headless)
  --size WxH     size of the pictures or of the window, for example 1280x720
  --no-install   only name missing system packages
  -- ...         is given to the demo; `cargo xtask demo -- --help` shows its options

It builds what `cargo xtask test` builds (same profile, same features), so the engine is compiled
once: some ten minutes on two cores the first time, seconds after that. The server's authority, its
token and its log are in demo-server/ in the build folder; nothing is written elsewhere.
";

pub(crate) fn run(mut args: Args) -> Result<(), Failure> {
    let install = !args.flag("--no-install");
    let local = args.flag("--local");
    let headless = args.flag("--headless");
    let out = args.value("--out")?;
    let frames = args.parsed::<u32>("--frames", "a number of frames")?;
    let size = args.value("--size")?;
    if let Some(size) = &size {
        check_size(size)?;
    }
    if !headless && (out.is_some() || frames.is_some()) {
        return Err("--out and --frames belong to --headless.".to_owned());
    }
    let mut options = Vec::new();
    if headless {
        let out = out.map_or_else(|| environment::target_dir().join("demo"), PathBuf::from);
        options.extend(["--headless".to_owned(), "--out".to_owned(), out.display().to_string()]);
    }
    if let Some(frames) = frames {
        options.extend(["--frames".to_owned(), frames.to_string()]);
    }
    if let Some(size) = size {
        options.extend(["--size".to_owned(), size]);
    }
    options.extend(args.finish()?);

    let purpose = if headless { Purpose::Render } else { Purpose::Window };
    setup::prepare(&[Purpose::Build, Purpose::Render, purpose], install);
    let example = if local { LOCAL } else { REMOTE };
    let [program, server] = build_both([example, SERVER])?;
    let asks_for_help = options.iter().any(|option| option == "--help" || option == "-h");
    if !headless && !asks_for_help && !has_display() {
        return Err("there is no display (DISPLAY is not set). Without one: \
                    cargo xtask demo --headless --out DIR"
            .to_owned());
    }
    let mut game = command(&program, headless);
    if local || asks_for_help {
        return process::run(game.args(options));
    }
    // In the build folder, wherever cargo has it: beside debug/ or release/.
    let build = server.parent().and_then(Path::parent);
    let folder = build.map_or_else(environment::target_dir, Path::to_path_buf).join("demo-server");
    let mut server = LightingServer::start(&server, &folder)?;
    let played = process::run(game.arg("--server-file").arg(server.invitation()).args(options));
    // If the server ended first, that is the reason of whatever the game says.
    server.check().and(played)
}

/// The demo's program, ready to be given options.
pub(crate) fn command(program: &Path, headless: bool) -> Command {
    let mut command = Command::new(program);
    // Where Bevy looks for assets; `cargo run` would set the second one.
    command.env("BEVY_ASSET_ROOT", process::root()).env("CARGO_MANIFEST_DIR", process::root());
    if headless {
        environment::for_headless(&mut command);
    } else {
        environment::for_any_render(&mut command);
    }
    command
}

/// Builds the demo that needs no server, and returns its program.
pub(crate) fn build() -> Result<PathBuf, Failure> {
    build_both([LOCAL, SERVER]).map(|[program, _]| program)
}

/// Builds an example and a command and returns their programs.
///
/// `cargo run` knows no `--workspace`, and without it cargo resolves the features of the umbrella
/// alone, which builds the engine a second time; so cargo builds, and we run.
fn build_both(names: [&str; 2]) -> Result<[PathBuf; 2], Failure> {
    let mut cargo = process::cargo();
    cargo.args(["build", "--workspace", "--example", names[0], "--bin", names[1]]);
    cargo.arg("--message-format=json-render-diagnostics");
    let mut programs = [const { None }; 2];
    let built = process::run_by_line(&mut cargo, |line| {
        if let Some(path) = executable(line)
            && let Some(i) = names.iter().position(|name| path.file_stem() == Some(name.as_ref()))
        {
            programs[i] = Some(path);
        }
    })?;
    if !built {
        return Err("the demo does not build (see above).".to_owned());
    }
    let [Some(example), Some(command)] = programs else {
        return Err("cargo did not say where it built the demo.".to_owned());
    };
    Ok([example, command])
}

/// The program that a JSON message of cargo names (field `executable` of `compiler-artifact`).
pub(crate) fn executable(message: &str) -> Option<PathBuf> {
    let (_, rest) = message.split_once("\"executable\":\"")?;
    let (path, _) = rest.split_once('"')?;
    // The only escapes in a path are Windows' separators.
    Some(PathBuf::from(path.replace("\\\\", "\\")))
}

/// Whether a window can open; other systems than Linux always have a screen.
fn has_display() -> bool {
    !cfg!(target_os = "linux") || std::env::var_os("DISPLAY").is_some_and(|name| !name.is_empty())
}

fn check_size(size: &str) -> Result<(), Failure> {
    let side = |text: &str| text.parse::<u32>().is_ok_and(|side| (1..=16384).contains(&side));
    match size.split_once('x') {
        Some((width, height)) if side(width) && side(height) => Ok(()),
        _ => Err(format!("--size needs WIDTHxHEIGHT in pixels, such as 1280x720, not '{size}'.")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_program_is_read_from_cargo_s_message() {
        let message =
            r#"{"reason":"compiler-artifact","executable":"C:\\t\\local_room.exe","fresh":true}"#;
        assert_eq!(executable(message), Some(PathBuf::from(r"C:\t\local_room.exe")));
        assert_eq!(executable(r#"{"reason":"compiler-artifact","executable":null}"#), None);
    }

    #[test]
    fn sizes() {
        assert_eq!(check_size("320x180"), Ok(()));
        for wrong in ["320", "0x180", "320x", "wide", "99999x1", "-3x4"] {
            assert!(check_size(wrong).is_err(), "{wrong}");
        }
    }
}
