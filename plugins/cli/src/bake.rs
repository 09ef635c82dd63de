//! `farlight bake`: the path tracer's answer at given points.

use std::{ops::ControlFlow, path::PathBuf, time::Instant};

use farlight_gi_solver::{
    World,
    estimate::GatherSettings,
    import::{ImportOptions, load_scene},
    probe::gather_probes,
    receiver::gather_receivers,
    scene::{Light, Sky},
};
use glam::Vec3;

use crate::{error::CliError, job::Job, output::Output, progress};

/// Compute irradiance, probes and visibility at given points of a glTF scene
///
/// Traces light paths until they end, without a limit on reflections; surfaces are diffuse and
/// reflect on both sides. Results are the same for the same seed on any number of threads.
///
/// Direct light is what arrives straight from point, spot and directional lights, and from the sky.
/// Everything else is indirect, light from emissive surfaces included (emissiveFactor times
/// KHR_materials_emissive_strength is their radiance).
#[derive(clap::Args)]
#[command(after_long_help = FORMATS)]
pub(crate) struct Args {
    /// The scene: a .glb or .gltf file with KHR_lights_punctual lights
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// What to compute, as JSON (see below)
    #[arg(long, value_name = "IN.json")]
    receivers: PathBuf,
    /// Where the answers go, as JSON in the same order (see below); written whole or not at all
    #[arg(long, value_name = "OUT.json")]
    result: PathBuf,
    /// Paths a receiver and probe, rounded up to a multiple of 32: four times as many halve the
    /// noise (powers of two do better)
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(1..=1 << 30))]
    samples: u32,
    /// Seed of all random numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Radiance of the sky, the same from everywhere; black if not given
    #[arg(long, value_name = "R,G,B", value_parser = parse_rgb)]
    sky: Option<Vec3>,
    /// Metres a unit of the file: 0.001 for files in millimetres. Points in IN.json are in metres
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = parse_scale)]
    scale: f32,
    /// Let point and spot lights end at their range (20 m where the file gives none) as Bevy does;
    /// otherwise they fall with the square of the distance alone
    #[arg(long)]
    range_window: bool,
}

const FORMATS: &str = "\
IN.json (every part may be left out; light = index in the order of the light nodes in the file):
  {\"surface\": [{\"position\": [x, y, z], \"normal\": [x, y, z]}],
   \"probes\": [[x, y, z]],
   \"visibility\": [{\"point\": [x, y, z], \"light\": 0}]}

OUT.json:
  {\"surface\": [{\"direct\": [r, g, b], \"indirect\": [r, g, b], \"indirect_se\": [r, g, b],
                \"indirect_one_bounce\": [r, g, b], \"indirect_one_bounce_se\": [r, g, b]}],
   \"probes\": [{\"sh\": [[r, g, b] x 9], \"sh_se\": [[r, g, b] x 9]}],
   \"visibility\": [0 or 1]}

  direct, indirect     irradiance on the side of the normal (W/m2, or lx)
  indirect_one_bounce  the part of it that was reflected once at most
  sh                   incident indirect radiance in real orthonormal spherical harmonics, order
                       (0,0) (1,-1) (1,0) (1,1) (2,-2) .. (2,2), polar axis z, no Condon-Shortley
                       phase, not convolved with the cosine
  *_se                 standard error of the mean (one sigma)
  visibility           1 where nothing lies between the point and the light";

/// Three numbers with commas, finite and not negative.
fn parse_rgb(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = text
        .split(',')
        .map(|t| t.trim().parse().map_err(|_| format!("{t:?} is not a number")))
        .collect::<Result<_, _>>()?;
    let [r, g, b] = numbers[..] else {
        return Err(format!("{} numbers, must be three: R,G,B", numbers.len()));
    };
    let rgb = Vec3::new(r, g, b);
    if rgb.is_finite() && rgb.min_element() >= 0.0 {
        Ok(rgb)
    } else {
        Err("must be finite and not negative".to_owned())
    }
}

/// A finite number above 0.
fn parse_scale(text: &str) -> Result<f32, String> {
    let scale: f32 = text.parse().map_err(|_| "not a number".to_owned())?;
    if scale.is_finite() && scale > 0.0 {
        Ok(scale)
    } else {
        Err("must be finite and above 0".to_owned())
    }
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let start = Instant::now();
    let options = ImportOptions {
        scale: args.scale,
        range_window: args.range_window,
        ..ImportOptions::default()
    };
    let mut imported = load_scene(&args.scene, &options)?;
    for warning in &imported.warnings {
        eprintln!("warning: {}: {warning}", args.scene.display());
    }
    let lights: Vec<Light> =
        imported.light_ids.iter().filter_map(|id| imported.scene.lights.get(id)).copied().collect();
    let job = Job::read(&args.receivers, lights.len())?;
    for warning in &job.warnings {
        eprintln!("warning: {warning}");
    }
    if let Some(radiance) = args.sky {
        imported.scene.sky = Sky::Constant(radiance);
    }
    Output::check_writable(&args.result)?;
    let world = World::new(&imported.scene);

    let settings = GatherSettings { paths: args.samples, seed: args.seed };
    let gathers = (job.receivers.len() + job.probes.len()) as u64;
    let bar = progress::bar(gathers * settings.traced(), "{human_pos} of {human_len} paths");
    let progress = |paths| {
        bar.inc(paths);
        ControlFlow::Continue(())
    };
    let stopped = || CliError::new("stopped");
    let receivers =
        gather_receivers(&world, &job.receivers, &settings, &progress).ok_or_else(stopped)?;
    let probes = gather_probes(&world, &job.probes, &settings, &progress).ok_or_else(stopped)?;
    let visibility =
        job.visibility.iter().map(|(point, light)| world.sees_light(*point, &lights[*light]));
    let output = Output::new(&receivers, &probes, visibility.collect())?;
    bar.finish_and_clear();
    output.write(&args.result)?;
    println!(
        "{}: {} receivers, {} probes, {} visibilities; {} paths each; {:.1} s",
        args.result.display(),
        job.receivers.len(),
        job.probes.len(),
        job.visibility.len(),
        settings.traced(),
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours() {
        assert_eq!(parse_rgb("1, 2.5,0"), Ok(Vec3::new(1.0, 2.5, 0.0)));
        for bad in ["1,2", "1,2,3,4", "1,x,2", "1,-1,2", "1,inf,2", "1,NaN,2", ""] {
            assert!(parse_rgb(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn scales() {
        assert_eq!(parse_scale("0.001"), Ok(0.001));
        for bad in ["0", "-1", "inf", "NaN", "m"] {
            assert!(parse_scale(bad).is_err(), "{bad}");
        }
    }
}
