//! The command line.

use std::path::PathBuf;

use bevy::math::UVec2;

use crate::frame_time::{self, FrameOptions};

const HELP: &str = "\
How long a frame takes when a measured material fills the screen, beside StandardMaterial.

USAGE
    btf_frame_time [OPTIONS] [MATERIAL]

MATERIAL is an .fbtf file or a BTFbase binary; without it: wallpaper in the folder that
FARLIGHT_TEST_DATA names, or a made one.

OPTIONS
    --size WxH      pixels (default 256x256)
    --rounds N      frames that count, of each subject (default 15)
    --fastest       the fastest frames count instead of the medians: for a busy machine
    --json FILE     the figures for programs, too
    --out DIR       pictures of what was drawn
";

pub(crate) struct Options {
    pub(crate) material: Option<PathBuf>,
    pub(crate) size: UVec2,
    pub(crate) frames: FrameOptions,
}

impl Options {
    pub(crate) fn from_args() -> Result<Self, String> {
        let mut options =
            Self { material: None, size: UVec2::splat(256), frames: FrameOptions::new(15) };
        let mut args = std::env::args().skip(1);
        while let Some(arg) = args.next() {
            let mut value = || args.next().ok_or(format!("{arg} needs a value"));
            match arg.as_str() {
                "-h" | "--help" => {
                    print!("{HELP}");
                    std::process::exit(0);
                }
                "--size" => options.size = frame_time::size(&value()?)?,
                _ if options.frames.take(&arg, &mut value)? => {}
                _ if arg.starts_with('-') => return Err(format!("unknown argument {arg}")),
                _ => options.material = Some(arg.into()),
            }
        }
        Ok(options)
    }
}
