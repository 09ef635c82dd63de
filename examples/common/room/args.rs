//! The command line.

use std::{path::PathBuf, time::Duration};

use super::program::number;

/// What `--help` prints, for the example `name`; `about` says in a few lines who solves the light.
pub fn help(name: &str, about: &str, takes_server: bool) -> String {
    let (usage, options) = if takes_server { (" SERVER", SERVER_HELP) } else { ("", "") };
    let blank = " ".repeat(36_usize.saturating_sub(name.len() + usage.len()));
    format!(
        "\
A bright room, a dark room and a doorway between them, lit indirectly while the light moves.

{about}

USAGE
    {name}{usage} {blank}in a window; the keys are on screen
    {name}{usage} --headless --out DIR
                                         without a window: measures, writes pictures and a report
    {name}{usage} --soak SECONDS
                                         without a window: watches memory, prints JSON lines

OPTIONS
{options}{OPTIONS}
EXAMPLES
    {name}{usage} --headless --out pictures
    {name}{usage} --headless --out pictures --frames 60 --size 160x90 --samples 64
    {name}{usage} --soak 600
"
    )
}

const SERVER_HELP: &str = "\
    --server INVITE   the server, as `farlight serve` prints it: farlight://HOST:PORT/#TOKEN.SHA256
    --server-file F   the same, read from a file, which need not be there yet
                      (SERVER in the lines above and below is one of these two)
";

const OPTIONS: &str = "\
    --headless        no window. Writes into DIR:
                        direct-only.png   what Bevy shows without this project
                        indirect.png      the same instant with live indirect light
                        reference.png     the same instant, indirect light path traced until converged
                        lightmap.png      the live lightmap alone
                        report.json       the measurements, also printed as a table
    --out DIR         where the files go; made if it is missing
    --frames N        stop measuring after about N frames; a short run measures less
                      (default: as many as the measurements need)
    --size WxH        size of the pictures in pixels, 16 to 4096 a side (default 320x180), or of the
                      window (default 1280x720)
    --lightmap N      edge of the lightmap in texels, 16 to 4096, a power of two (default 128)
    --samples N       paths a texel of the converged reference, 1 to 65536 (default 2048)
    --seed N          seed of all random numbers (default 1)
    --soak SECONDS    run that long with a moving light and print up to 60 JSON lines about memory;
                      fails if memory grew after the warm-up (the first fifth)
    -h, --help        this text

EXIT STATUS
    0 done; 1 no lighting arrived, a picture is black, or memory grew; 2 the command line is wrong
";

/// What the program is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Mode {
    /// Print [`help`].
    Help,
    /// Show it.
    Window,
    /// Measure, write pictures and a report into a folder.
    Headless {
        /// Where the files go.
        out: PathBuf,
        /// About how many frames are measured at most.
        frames: Option<u32>,
    },
    /// Watch memory.
    Soak(Duration),
}

/// Where the invitation of a lighting server is.
#[derive(Clone, Debug, PartialEq)]
pub enum Server {
    /// The invitation itself.
    Invitation(String),
    /// A file that holds it.
    File(PathBuf),
}

/// The parsed command line.
#[derive(Clone, Debug, PartialEq)]
pub struct Args {
    /// What to do.
    pub mode: Mode,
    /// Size of the pictures in pixels.
    pub size: (u32, u32),
    /// Size of the window in logical pixels.
    pub window: (u32, u32),
    /// Edge of the lightmap in texels.
    pub lightmap: u32,
    /// Paths a texel of the converged reference.
    pub samples: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Who solves the light, for examples that ask a server.
    pub server: Option<Server>,
}

impl Args {
    /// Reads the arguments, the program's name left out. With `takes_server` a server must be named.
    pub fn parse(
        arguments: impl IntoIterator<Item = String>,
        takes_server: bool,
    ) -> Result<Self, String> {
        let mut args = Self {
            mode: Mode::Window,
            size: (320, 180),
            window: (1280, 720),
            lightmap: 128,
            samples: 2048,
            seed: 1,
            server: None,
        };
        let (mut headless, mut out, mut frames, mut soak) = (false, None, None, None);
        let mut arguments = arguments.into_iter();
        while let Some(name) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{name} needs a value"));
            match name.as_str() {
                "-h" | "--help" => return Ok(Self { mode: Mode::Help, ..args }),
                "--headless" => headless = true,
                "--out" => out = Some(PathBuf::from(value()?)),
                "--frames" => frames = Some(number(&name, &value()?, 1, 1_000_000)?),
                "--size" => {
                    args.size = size(&value()?)?;
                    args.window = args.size;
                }
                "--lightmap" => {
                    args.lightmap = number(&name, &value()?, 16, 4096)?;
                    if !args.lightmap.is_power_of_two() {
                        return Err(format!("--lightmap {}: not a power of two", args.lightmap));
                    }
                }
                "--samples" => args.samples = number(&name, &value()?, 1, 65536)?,
                "--seed" => args.seed = number(&name, &value()?, 0, u64::MAX)?,
                "--server" | "--server-file" if takes_server && args.server.is_some() => {
                    return Err("name one server: --server or --server-file".into());
                }
                "--server" if takes_server => args.server = Some(Server::Invitation(value()?)),
                "--server-file" if takes_server => {
                    args.server = Some(Server::File(PathBuf::from(value()?)));
                }
                "--soak" => soak = Some(number(&name, &value()?, 1, 1_000_000)?),
                _ => return Err(format!("unknown argument {name}; --help lists them")),
            }
        }
        args.mode = match (headless, out, soak) {
            (true, Some(out), None) => Mode::Headless { out, frames },
            (true, None, None) => return Err("--headless needs --out DIR".into()),
            (_, None, Some(seconds)) => Mode::Soak(Duration::from_secs(seconds)),
            (_, Some(_), Some(_)) => return Err("--soak writes no files; leave out --out".into()),
            (false, Some(_), None) => return Err("--out needs --headless".into()),
            (false, None, None) => Mode::Window,
        };
        if takes_server && args.server.is_none() {
            return Err("name a server: --server INVITE or --server-file FILE; \
                        `farlight serve` starts one and prints its invitation"
                .into());
        }
        Ok(args)
    }
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let Some((width, height)) = text.split_once('x') else {
        return Err(format!("--size {text}: write WIDTHxHEIGHT, for example 320x180"));
    };
    let side = |t: &str| number("--size", t, 16, 4096);
    Ok((side(width)?, side(height)?))
}
