//! `farlight ibl`: light from environment maps.

/// Ends the help of each subcommand.
macro_rules! maps {
    () => {
        "\
ENV is a file of any of these kinds, told by its content:
  Radiance (.hdr)    RGBE, plain or with run lengths
  OpenEXR (.exr)     R, G and B, or Y, as half or single floats
  KTX2 (.ktx2)       cubes and pictures: R16G16B16A16_SFLOAT, R32G32B32A32_SFLOAT, E5B9G9R9, B10G11R11,
                     R8G8B8A8 (SRGB, UNORM), with Zstandard or without
  PNG, JPEG          sRGB; white is the brightest light that they hold

Its layout is told by its shape (--layout auto):
  equirect   2:1, longitude and latitude: the centre is -z, right is +x, the first row is up
  angular    1:1, Debevec's light probes: the centre is -z, the circle straight back
  cube       KTX2 cubes; crosses (4:3, 3:4), strips (6:1, 1:6) of +X -X +Y -Y +Z -Z, where +Z is ahead

METHOD is one of
  independent   each light is drawn by itself, by luminance and solid angle
  stratified    the same at low-discrepancy points
  regions       the map cut into regions of equal luminous energy, a light at a random point of each
  centroids     such regions, smaller where little else shines, a light in the middle of each one's energy

Maps of more than 2048 x 1024 texels are averaged down, which keeps their energy."
    };
}

mod compare;
mod lights;
mod picture;
mod plot;

use std::path::PathBuf;

use clap::Subcommand;
use farlight_environment::{Environment, Layout};

use crate::error::CliError;

/// Environment maps: as directional lights, and how well these replace them
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Lights(lights::Args),
    Compare(compare::Args),
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    match &args.command {
        Command::Lights(args) => lights::run(args),
        Command::Compare(args) => compare::run(args),
    }
}

/// A map on the command line.
#[derive(clap::Args)]
struct Source {
    /// The environment map (see below)
    #[arg(value_name = "ENV")]
    path: PathBuf,
    /// How the map is laid out: auto, equirect, angular or cube
    #[arg(long, value_name = "LAYOUT", default_value_t = Layout::Auto)]
    layout: Layout,
}

impl Source {
    /// Opens it, and says on the standard error what was wrong with its values.
    fn open(&self) -> Result<Environment, CliError> {
        let map = Environment::open(&self.path, self.layout)?;
        let repairs = map.repairs();
        for (count, what) in [
            (repairs.nan, "no numbers; set to 0"),
            (repairs.infinite, "infinite or above 1e30; set to the largest other value"),
            (repairs.negative, "negative; set to 0"),
        ] {
            if count > 0 {
                eprintln!("warning: {}: {count} values are {what}", self.path.display());
            }
        }
        Ok(map)
    }
}

/// Fails unless a file has one of these endings.
fn check_ending(path: &std::path::Path, ending: &str) -> Result<(), CliError> {
    let found = path.extension().unwrap_or_default().to_ascii_lowercase();
    if found == *ending {
        return Ok(());
    }
    Err(CliError::new(format!("{}: must end in .{ending}", path.display())))
}
