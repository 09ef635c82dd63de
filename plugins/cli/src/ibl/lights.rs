//! `farlight ibl lights`: a map as directional lights.

use std::{io::Write, path::PathBuf};

use farlight_environment::{EnvironmentLight, LightRequest, Method};
use serde::Serialize;

use super::{Source, check_ending, picture};
use crate::{error::CliError, output::WholeFile};

/// Turn an environment map into directional lights
///
/// The sum of the lights lights a surface as the map does. Any n consecutive ones of the N, times N / n,
/// are an estimate of that.
#[derive(clap::Args)]
#[command(after_help = FORMAT, after_long_help = FORMAT)]
pub(crate) struct Args {
    #[command(flatten)]
    source: Source,
    /// How many lights
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=4096))]
    count: u32,
    /// How they are found (see below)
    #[arg(long, value_name = "METHOD", default_value_t = Method::default())]
    method: Method,
    /// Other seeds give other lights, which are as good
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Where the lights go, as JSON (see below); written whole or not at all
    #[arg(long, value_name = "OUT.json")]
    out: PathBuf,
    /// A picture of the map with the lights as dots
    #[arg(long, value_name = "X.png")]
    picture: Option<PathBuf>,
}

const FORMAT: &str = concat!(
    "\
OUT.json: [{\"direction\":[x,y,z],\"irradiance\":[r,g,b]}, ..]
  direction    unit vector towards the light, in the map's frame: right-handed, y up, -z in the centre
  irradiance   of a plane that faces the light, linear Rec. 709, in the map's unit of radiance times steradian

",
    maps!()
);

/// A light as it stands in the file.
#[derive(Serialize)]
struct Light {
    direction: [f32; 3],
    irradiance: [f32; 3],
}

impl From<EnvironmentLight> for Light {
    fn from(light: EnvironmentLight) -> Self {
        Self { direction: light.direction.into(), irradiance: light.irradiance.into() }
    }
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let mut out = WholeFile::create(&args.out)?;
    let picture = match &args.picture {
        Some(path) => {
            check_ending(path, "png")?;
            Some((path, WholeFile::create(path)?))
        }
        None => None,
    };
    let map = args.source.open()?;
    let request = LightRequest { count: args.count, method: args.method, seed: args.seed };
    let lights = map.lights(&request);
    let list: Vec<Light> = lights.iter().copied().map(Light::from).collect();
    serde_json::to_writer(&mut out, &list)
        .map_err(std::io::Error::from)
        .and_then(|()| out.write_all(b"\n"))
        .map_err(|error| CliError::io(&args.out, "written", &error))?;
    out.finish()?;
    if let Some((path, mut file)) = picture {
        let png = picture::draw(&map, &lights)?;
        file.write_all(&png).map_err(|error| CliError::io(path, "written", &error))?;
        file.finish()?;
    }
    if map.texels().iter().all(|texel| *texel == glam::Vec3::ZERO) {
        eprintln!("warning: {}: the map is black", args.source.path.display());
    }
    println!(
        "{}: {} lights ({}) of a map of {} x {} texels",
        args.out.display(),
        lights.len(),
        args.method,
        map.width(),
        map.height()
    );
    Ok(())
}
