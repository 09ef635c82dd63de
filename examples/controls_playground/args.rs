//! The command line.

use std::path::PathBuf;

use super::program::size;

/// What `--help` prints.
pub const HELP: &str = "\
Every action live, for the device in hand.

USAGE
    controls_playground [OPTIONS]                       in a window
    controls_playground --headless --out DIR [OPTIONS]  without a window: pictures as PNG files

OPTIONS
    --config FILE  bindings, as RON (`farlight controls defaults` writes all of them); followed when
                   the file changes, in a build with Bevy's feature file_watcher
    --record FILE  write what the actions said, frame by frame
    --replay FILE  say it again
    --size WxH     of the pictures or of the window, 320 to 4096 a side (default 1280x720)
    --headless     no window. Uses each kind of device once and writes into DIR
                     keyboard_mouse.png, gamepad.png, touch.png, xr_touch.png
                   and what the actions said meanwhile, NAME.recording. With --replay instead:
                     replay.png, at the end of the recording
    --out DIR      where they go; made if it is missing
    -h, --help     this text

EXAMPLES
    cargo run --example controls_playground
    cargo run --example controls_playground -- --headless --out pictures
    cargo run --example controls_playground -- --headless --out pictures --replay pictures/gamepad.recording

EXIT STATUS
    0 done; 1 something could not be read or drawn; 2 the command line is wrong
";

/// What the program is asked to do.
#[derive(Clone, Debug)]
pub struct Args {
    /// Print [`HELP`].
    pub help: bool,
    /// A file of bindings.
    pub config: Option<PathBuf>,
    /// Where the recording goes.
    pub record: Option<PathBuf>,
    /// A recording to be said again.
    pub replay: Option<PathBuf>,
    /// Size of pictures or window.
    pub size: (u32, u32),
    /// Where pictures go; none opens a window.
    pub out: Option<PathBuf>,
}

impl Args {
    /// Reads the arguments, the program's name left out.
    pub fn parse(arguments: impl IntoIterator<Item = String>) -> Result<Self, String> {
        let mut args = Self {
            help: false,
            config: None,
            record: None,
            replay: None,
            size: (1280, 720),
            out: None,
        };
        let mut headless = false;
        let mut arguments = arguments.into_iter();
        while let Some(name) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{name} needs a value"));
            match name.as_str() {
                "-h" | "--help" => return Ok(Self { help: true, ..args }),
                "--config" => args.config = Some(value()?.into()),
                "--record" => args.record = Some(value()?.into()),
                "--replay" => args.replay = Some(value()?.into()),
                "--size" => args.size = size(&value()?, 320..=4096)?,
                "--headless" => headless = true,
                "--out" => args.out = Some(value()?.into()),
                other => return Err(format!("{other} is not understood; --help lists all")),
            }
        }
        match (headless, &args.out) {
            (true, None) => Err("--headless needs --out DIR".into()),
            (false, Some(_)) => Err("--out needs --headless".into()),
            _ => Ok(args),
        }
    }

    /// The file of bindings as an asset.
    pub fn config(&self) -> Result<Option<String>, String> {
        let Some(path) = &self.config else { return Ok(None) };
        let full = path.canonicalize().map_err(|e| format!("{}: {e}", path.display()))?;
        if full.to_string_lossy().ends_with(".controls.ron") {
            return Ok(Some(full.display().to_string()));
        }
        Err(format!("{}: its name must end with .controls.ron", path.display()))
    }
}
