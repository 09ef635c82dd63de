//! `cargo xtask demo`: the room with global illumination, from a fresh clone to pictures.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::args::Args;
use crate::setup::{self, Purpose};
use crate::{Failure, environment, process};

/// The example that is the demo.
const EXAMPLE: &str = "local_room";

pub(crate) const HELP: &str = "\
cargo xtask demo [--no-install] [-- OPTIONS OF THE DEMO]
cargo xtask demo --headless --out DIR [--frames N] [--size WxH] [--no-install]

Looks for missing system packages, builds the example `local_room`, and runs it: a bright and a dark
room, a doorway between them, and a light that moves. In a window the keys are on screen.

  --headless     render without a window; writes direct-only.png, indirect.png, reference.png and
                 report.json, and fails if no update of the light arrived or the pictures are black
  --out DIR      where to (with --headless; default: demo/ in the build folder)
  --frames N     how many frames to render (with --headless)
  --size WxH     size of the pictures or of the window, for example 1280x720
  --no-install   only name missing system packages
  -- ...         is given to the demo; `cargo xtask demo -- --help` shows its options

It builds what `cargo xtask test` builds (same profile, same features), so the engine is compiled
once: some ten minutes on two cores the first time, seconds after that.
";

pub(crate) fn run(mut args: Args) -> Result<(), Failure> {
    let install = !args.flag("--no-install");
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
    let program = build()?;
    let asks_for_help = options.iter().any(|option| option == "--help");
    if !headless && !asks_for_help && !has_display() {
        return Err("there is no display (DISPLAY is not set). Without one: \
                    cargo xtask demo --headless --out DIR"
            .to_owned());
    }
    process::run(command(&program, headless).args(options))
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

/// Builds the demo and returns its program.
///
/// `cargo run` knows no `--workspace`, and without it cargo resolves the features of the umbrella
/// alone, which builds the engine a second time; so cargo builds, and we run.
pub(crate) fn build() -> Result<PathBuf, Failure> {
    let mut cargo = process::cargo();
    cargo.args(["build", "--workspace", "--example", EXAMPLE]);
    cargo.arg("--message-format=json-render-diagnostics");
    let mut program = None;
    let built = process::run_by_line(&mut cargo, |line| {
        if let Some(path) = executable(line)
            && path.file_stem().is_some_and(|stem| stem == EXAMPLE)
        {
            program = Some(path);
        }
    })?;
    if !built {
        return Err("the demo does not build (see above).".to_owned());
    }
    program.ok_or_else(|| "cargo did not say where it built the demo.".to_owned())
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
