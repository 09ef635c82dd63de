//! The command line.

use std::path::PathBuf;

use bevy::math::UVec2;

const HELP: &str = "\
How long a frame takes while the environment's light refines, beside plain lights.

USAGE
    ibl_frame_time [OPTIONS]

OPTIONS
    --size WxH      pixels; may be given more than once (default 640x360 and 1280x720)
    --rounds N      frames that count, of each subject (default 30)
    --fastest       the fastest frames count instead of the medians: for a busy machine
    --json FILE     the figures for programs, too
    --out DIR       pictures of what was drawn
";

pub(crate) struct Options {
    pub(crate) sizes: Vec<UVec2>,
    pub(crate) rounds: usize,
    pub(crate) fastest: bool,
    pub(crate) json: Option<PathBuf>,
    pub(crate) out: Option<PathBuf>,
}

impl Options {
    pub(crate) fn from_args() -> Result<Self, String> {
        let mut options =
            Self { sizes: Vec::new(), rounds: 30, fastest: false, json: None, out: None };
        let mut args = std::env::args().skip(1);
        while let Some(arg) = args.next() {
            let mut value = || args.next().ok_or(format!("{arg} needs a value"));
            match arg.as_str() {
                "-h" | "--help" => {
                    print!("{HELP}");
                    std::process::exit(0);
                }
                "--size" => options.sizes.push(size(&value()?)?),
                "--rounds" => {
                    let text = value()?;
                    let rounds = text.parse().ok().filter(|rounds| (1..=100_000).contains(rounds));
                    options.rounds = rounds.ok_or(format!("--rounds: not '{text}'"))?;
                }
                "--fastest" => options.fastest = true,
                "--json" => options.json = Some(value()?.into()),
                "--out" => options.out = Some(value()?.into()),
                _ => return Err(format!("unknown argument {arg}")),
            }
        }
        if options.sizes.is_empty() {
            options.sizes = vec![UVec2::new(640, 360), UVec2::new(1280, 720)];
        }
        Ok(options)
    }
}

fn size(text: &str) -> Result<UVec2, String> {
    let side = |text: &str| text.parse().ok().filter(|side| (16..=4096).contains(side));
    text.split_once('x')
        .and_then(|(width, height)| Some(UVec2::new(side(width)?, side(height)?)))
        .ok_or(format!("--size needs WIDTHxHEIGHT, 16 to 4096 a side, not '{text}'"))
}
