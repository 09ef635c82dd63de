//! The command line.

use std::path::PathBuf;

use super::program::{number, size};

/// What `--help` prints.
pub const HELP: &str = "\
A gallery of three rooms to walk about in, on the desktop or with a headset: one program for both.
Indirect light is solved while you look, and follows the lantern that you carry about.

USAGE
    xr_gallery [OPTIONS]                      with the headset if there is one, else in a window
    xr_gallery --headless --out DIR [OPTIONS] without both: a tour as PNG files and a short report

OPTIONS
    --xr off            no headset, even if there is one
    --server INVITE     let a lighting server solve: farlight://HOST:PORT/#TOKEN.SHA256, as
                        `farlight serve` prints it; without one a thread of this program solves
    --server-file F     the same, read from a file, which need not be there yet
    --texels N          lightmap texels a metre, 1 to 64 (default 8)
    --paths N           paths a texel until the light counts as converged, 64 to 65536
                        (default 4096; for a tour 512)
    --seed N            seed of all random numbers (default 1)
    --size WxH          of the pictures (default 960x540) or of the window (default 1280x720), 16 to
                        8192 a side
    --headless          no window, no headset
    --out DIR           where the pictures go
    --frames N          how many further pictures of the turning sculpture (default 0), up to 360
    -h, --help          this text

EXAMPLES
    cargo run --example xr_gallery
    cargo run --example xr_gallery -- --xr off --server-file light.invite
    cargo run --example xr_gallery -- --headless --out tour

EXIT STATUS
    0 done; 1 something could not be read, lit or drawn; 2 the command line is wrong
";

/// Where the invitation of a lighting server is.
#[derive(Clone, Debug, PartialEq)]
pub enum Server {
    /// The invitation itself.
    Invitation(String),
    /// A file that holds it.
    File(PathBuf),
}

/// What the program is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Args {
    /// Print [`HELP`].
    pub help: bool,
    /// Who solves the light, if not this program.
    pub server: Option<Server>,
    /// Lightmap texels a metre.
    pub texels: u32,
    /// Paths a texel of converged light.
    pub paths: Option<u32>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Of pictures or window, in pixels.
    pub size: Option<(u32, u32)>,
    /// Where the tour's pictures go.
    pub tour: Option<PathBuf>,
    /// Pictures of the turning sculpture.
    pub frames: u32,
}

impl Args {
    /// Reads the arguments, the program's name left out.
    pub fn parse(arguments: impl IntoIterator<Item = String>) -> Result<Self, String> {
        let mut args = Self {
            help: false,
            server: None,
            texels: 8,
            paths: None,
            seed: 1,
            size: None,
            tour: None,
            frames: 0,
        };
        let (mut headless, mut out) = (false, None);
        let mut arguments = arguments.into_iter();
        while let Some(name) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{name} needs a value"));
            match name.as_str() {
                "-h" | "--help" => return Ok(Self { help: true, ..args }),
                // Read by the plugin of headsets.
                "--xr" => match value()?.as_str() {
                    "on" | "auto" | "off" => {}
                    other => return Err(format!("--xr {other}: not on or off")),
                },
                "--server" | "--server-file" if args.server.is_some() => {
                    return Err("name one server: --server or --server-file".into());
                }
                "--server" => args.server = Some(Server::Invitation(value()?)),
                "--server-file" => args.server = Some(Server::File(value()?.into())),
                "--texels" => args.texels = number(&name, &value()?, 1, 64)?,
                "--paths" => args.paths = Some(number(&name, &value()?, 64, 65_536)?),
                "--seed" => args.seed = number(&name, &value()?, 0, u64::MAX)?,
                "--size" => args.size = Some(size(&value()?, 16..=8192)?),
                "--frames" => args.frames = number(&name, &value()?, 0, 360)?,
                "--headless" => headless = true,
                "--out" => out = Some(PathBuf::from(value()?)),
                other => return Err(format!("{other}: unknown; --help lists what there is")),
            }
        }
        args.tour = match (headless, out) {
            (true, None) => return Err("--headless needs --out DIR".into()),
            (false, Some(_)) => return Err("--out goes with --headless".into()),
            (_, out) => out,
        };
        Ok(args)
    }
}
