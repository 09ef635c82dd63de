//! The command line.

use bevy::math::UVec2;

use crate::frame_time::{self, FrameOptions};

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
    pub(crate) frames: FrameOptions,
}

impl Options {
    pub(crate) fn from_args() -> Result<Self, String> {
        let mut options = Self { sizes: Vec::new(), frames: FrameOptions::new(30) };
        let mut args = std::env::args().skip(1);
        while let Some(arg) = args.next() {
            let mut value = || args.next().ok_or(format!("{arg} needs a value"));
            match arg.as_str() {
                "-h" | "--help" => {
                    print!("{HELP}");
                    std::process::exit(0);
                }
                "--size" => options.sizes.push(frame_time::size(&value()?)?),
                _ if options.frames.take(&arg, &mut value)? => {}
                _ => return Err(format!("unknown argument {arg}")),
            }
        }
        if options.sizes.is_empty() {
            options.sizes = vec![UVec2::new(640, 360), UVec2::new(1280, 720)];
        }
        Ok(options)
    }
}
