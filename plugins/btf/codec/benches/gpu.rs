//! Nanoseconds an evaluation in a compute kernel, beside the scalar evaluator on one core.
//!
//! `cargo bench -p farlight_btf_codec --bench gpu -- [OPTIONS] [MATERIAL ...]`
//!
//! Without materials: those of the folder in `FARLIGHT_TEST_DATA`, those that the suite ships, or a
//! Lambertian one.
//!
//! - `--rounds N` (default 9): each figure is the median of so many runs or, with `--fastest` for a
//!   busy machine, the minimum.
//! - `--count N` (default 262144): evaluations in a run.
//! - `--json FILE`: the same figures for programs.

mod support;

use std::process::ExitCode;
use std::time::Instant;

use farlight_btf_codec::gpu::{Clock, Gpu, GpuEvaluator};
use farlight_btf_codec::{Btf, Query, Rules, synthetic};
use glam::Vec3;
use serde::Serialize;
use support::{Options, random, raster};

#[derive(Serialize)]
struct Row {
    material: String,
    texels: [u32; 2],
    bytes: usize,
    order: &'static str,
    /// Lights of one view; none: a query has a light of its own.
    lights: Option<usize>,
    adapter: String,
    /// Of one light.
    gpu_nanoseconds: f64,
    /// The same on one core, one at a time.
    cpu_nanoseconds: f64,
}

/// Those of the options, or a Lambertian one.
fn materials(options: &Options) -> Result<Vec<Btf>, String> {
    let mut materials: Vec<Btf> = options.open().collect();
    if materials.is_empty() {
        let made = synthetic::lambert([0.5; 3], [64, 64]).map_err(|error| error.to_string())?;
        materials.push(made);
    }
    Ok(materials)
}

/// Lights all over the hemisphere: a spiral with equal areas.
fn lights(count: usize) -> Vec<Vec3> {
    (0..count)
        .map(|at| {
            let up = (at as f32 + 0.5) / count as f32;
            let (sin, cos) = (at as f32 * 2.399_963).sin_cos();
            let flat = (1.0 - up * up).sqrt();
            Vec3::new(flat * cos, flat * sin, up)
        })
        .collect()
}

/// Nanoseconds an evaluation of the scalar evaluator.
fn on_the_processor(btf: &Btf, queries: &[Query], options: &Options) -> f64 {
    let queries = &queries[..queries.len().min(1 << 14)];
    let mut times: Vec<f64> = (0..options.rounds)
        .map(|_| {
            let start = Instant::now();
            for query in queries {
                let value = btf.evaluate(query.x, query.y, query.angles, Rules::SHADING);
                std::hint::black_box(value);
            }
            start.elapsed().as_secs_f64() * 1e9 / queries.len() as f64
        })
        .collect();
    options.chosen(&mut times)
}

fn measure(gpu: &Gpu, btf: &Btf, options: &Options) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let size = btf.size();
    let orders = [("random", random(size, options.count)), ("raster", raster(size, options.count))];
    for (order, queries) in &orders {
        let cpu_nanoseconds = on_the_processor(btf, queries, options);
        for count in [None, Some(1), Some(5), Some(16)] {
            let evaluator = match count {
                None => GpuEvaluator::new(gpu, btf, Rules::SHADING),
                Some(count) => GpuEvaluator::with_lights(gpu, btf, Rules::SHADING, &lights(count)),
            };
            let timing = evaluator.and_then(|evaluator| evaluator.time(queries, options.rounds));
            let timing = timing.map_err(|error| error.to_string())?;
            let time = if options.fastest { timing.shortest } else { timing.median };
            let evaluations = timing.queries * count.unwrap_or(1);
            let row = Row {
                material: btf.info().name.clone(),
                texels: size,
                bytes: 4 * btf.words().len(),
                order,
                lights: count,
                adapter: gpu.adapter().to_owned(),
                gpu_nanoseconds: time.as_secs_f64() * 1e9 / evaluations as f64,
                cpu_nanoseconds,
            };
            let what = match count {
                None => "one light a query".to_owned(),
                Some(1) => "1 light".to_owned(),
                Some(count) => format!("{count} lights a view"),
            };
            println!(
                "{:<12} {:<8} {:<20} {:>9.2} ns {:>9.1} ns{}",
                row.material,
                row.order,
                what,
                row.gpu_nanoseconds,
                row.cpu_nanoseconds,
                if timing.clock == Clock::Computer { " (computer's clock)" } else { "" },
            );
            rows.push(row);
        }
    }
    Ok(rows)
}

fn run() -> Result<(), String> {
    let options = Options::from_args(1 << 18)?;
    let gpu = match Gpu::new() {
        Ok(gpu) => gpu,
        Err(error) => {
            println!("SKIPPED: {error}");
            return Ok(());
        }
    };
    println!("A compute kernel on {}, the scalar evaluator on one core; a light:", gpu.adapter());
    println!("{:<12} {:<8} {:<20} {:>12} {:>12}", "material", "order", "lights", "GPU", "CPU");
    let mut rows = Vec::new();
    for btf in materials(&options)? {
        rows.extend(measure(&gpu, &btf, &options)?);
    }
    options.write(&rows)
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
