//! `farlight bake --receivers`: the path tracer's answer at given points.

use std::{ops::ControlFlow, time::Instant};

use farlight_gi_solver::{
    World,
    estimate::GatherSettings,
    import::{ImportOptions, load_scene},
    probe::gather_probes,
    receiver::gather_receivers,
    scene::{Light, Sky},
};

use super::{Args, Points};
use crate::{error::CliError, job::Job, output::Output, progress};

/// Answers at points.
pub(super) fn run(args: &Args, points: &Points<'_>) -> Result<(), CliError> {
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
    let job = Job::read(points.receivers, lights.len())?;
    for warning in &job.warnings {
        eprintln!("warning: {warning}");
    }
    if let Some(radiance) = args.sky {
        imported.scene.sky = Sky::Constant(radiance);
    }
    Output::check_writable(points.result)?;
    let world = World::new(&imported.scene);

    let settings = GatherSettings { paths: args.samples.unwrap_or(4096), seed: args.seed };
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
    output.write(points.result)?;
    println!(
        "{}: {} receivers, {} probes, {} visibilities; {} paths each; {:.1} s",
        points.result.display(),
        job.receivers.len(),
        job.probes.len(),
        job.visibility.len(),
        settings.traced(),
        start.elapsed().as_secs_f64()
    );
    Ok(())
}
