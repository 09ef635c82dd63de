//! The command line.

use std::path::PathBuf;

use super::program::{number, size};

/// What `--help` prints.
pub const HELP: &str = "\
A day in a room: baked scenarios, blended at run time.

USAGE
    scenarios [OPTIONS]                       in a window; the keys are on screen
    scenarios --headless --out DIR [OPTIONS]  without a window: pictures as PNG files

OPTIONS
    --headless        no window. Writes into DIR:
                        day_00.png, ...   the room from 6 to 22 o'clock
                        strip.png         all of them beside each other
    --out DIR         where the pictures go; made if it is missing
    --pictures N      how many, 1 to 100 (default 9)
    --size WxH        of the pictures (default 320x180) or the window (default 1280x720)
    -h, --help        this text

EXIT STATUS
    0 done; 1 something could not be read or drawn; 2 the command line is wrong
";

/// What the program is asked to do.
#[derive(Clone, Debug)]
pub struct Args {
    /// Print [`HELP`].
    pub help: bool,
    /// How many pictures.
    pub pictures: u32,
    /// Size of pictures or window.
    pub size: (u32, u32),
    /// Where pictures go; none opens a window.
    pub out: Option<PathBuf>,
}

impl Args {
    /// Reads the arguments, the program's name left out.
    pub fn parse(arguments: impl IntoIterator<Item = String>) -> Result<Self, String> {
        let mut args = Self { help: false, pictures: 9, size: (0, 0), out: None };
        let mut headless = false;
        let mut arguments = arguments.into_iter();
        while let Some(name) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{name} needs a value"));
            match name.as_str() {
                "-h" | "--help" => return Ok(Self { help: true, ..args }),
                "--pictures" => args.pictures = number(&name, &value()?, 1, 100)?,
                "--size" => args.size = size(&value()?, 16..=4096)?,
                "--headless" => headless = true,
                "--out" => args.out = Some(PathBuf::from(value()?)),
                other => return Err(format!("{other}: unknown; --help lists what there is")),
            }
        }
        if args.size == (0, 0) {
            args.size = if headless { (320, 180) } else { (1280, 720) };
        }
        match (headless, &args.out) {
            (true, None) => Err("--headless needs --out DIR".into()),
            (false, Some(_)) => Err("--out goes with --headless".into()),
            _ => Ok(args),
        }
    }
}
