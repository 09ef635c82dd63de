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

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use farlight_btf_codec::gpu::{Clock, Gpu, GpuEvaluator};
use farlight_btf_codec::{Angles, Btf, Query, Rules, synthetic};
use glam::Vec3;
use serde::Serialize;

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

struct Options {
    materials: Vec<PathBuf>,
    rounds: usize,
    fastest: bool,
    count: usize,
    json: Option<PathBuf>,
}

fn options() -> Result<Options, String> {
    let mut options =
        Options { materials: Vec::new(), rounds: 9, fastest: false, count: 1 << 18, json: None };
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg} needs a value"));
        let number = |text: String| text.parse().map_err(|error| format!("{text}: {error}"));
        match arg.as_str() {
            "--bench" => {} // cargo's own
            "--rounds" => options.rounds = number(value()?)?,
            "--count" => options.count = number(value()?)?,
            "--fastest" => options.fastest = true,
            "--json" => options.json = Some(value()?.into()),
            _ if arg.starts_with('-') => return Err(format!("unknown argument {arg}")),
            _ => options.materials.push(arg.into()),
        }
    }
    if options.materials.is_empty() {
        options.materials = found();
    }
    Ok(options)
}

/// Measured materials and those of the suite.
fn found() -> Vec<PathBuf> {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/materials")];
    match std::env::var_os("FARLIGHT_TEST_DATA") {
        Some(data) => {
            for name in ["alu", "corduroy", "wallpaper"] {
                folders.push(PathBuf::from(&data).join("btfbase").join(name));
            }
        }
        None => println!("measured materials SKIPPED: FARLIGHT_TEST_DATA is not set"),
    }
    let mut found: Vec<PathBuf> = (folders.iter())
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flat_map(|entries| entries.flatten().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "fbtf" || e == "btf"))
        .collect();
    found.sort();
    found
}

fn materials(options: &Options) -> Result<Vec<Btf>, String> {
    if options.materials.is_empty() {
        let made = synthetic::lambert([0.5; 3], [64, 64]).map_err(|error| error.to_string())?;
        return Ok(vec![made]);
    }
    let read = |path: &PathBuf| {
        let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let bytes = std::fs::read(path).map_err(|error| wrong(&error))?;
        Btf::from_bytes(bytes).map_err(|error| wrong(&error))
    };
    options.materials.iter().map(read).collect()
}

/// The first numbers of SplitMix64 from 1, between 0 and 1.
fn random() -> impl FnMut() -> f32 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }
}

/// Any texel under any directions, uniform over both hemispheres.
fn random_order(size: [u32; 2], count: usize) -> Vec<Query> {
    let mut next = random();
    let mut query = || Query {
        x: (next() * size[0] as f32) as i32,
        y: (next() * size[1] as f32) as i32,
        angles: Angles {
            theta_i: next().acos(),
            phi_i: next() * std::f32::consts::TAU,
            theta_v: next().acos(),
            phi_v: next() * std::f32::consts::TAU,
        },
    };
    (0..count).map(|_| query()).collect()
}

/// The picture row by row under fixed directions.
fn raster_order(size: [u32; 2], count: usize) -> Vec<Query> {
    let angles = Angles { theta_i: 0.6, phi_i: 1.0, theta_v: 0.4, phi_v: 4.0 };
    (0..count as u32)
        .map(|at| Query { x: (at % size[0]) as i32, y: (at / size[0] % size[1]) as i32, angles })
        .collect()
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
    let mut times: Vec<f64> = (0..options.rounds.max(1))
        .map(|_| {
            let start = Instant::now();
            for query in queries {
                let value = btf.evaluate(query.x, query.y, query.angles, Rules::SHADING);
                std::hint::black_box(value);
            }
            start.elapsed().as_secs_f64() * 1e9 / queries.len() as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[if options.fastest { 0 } else { times.len() / 2 }]
}

fn measure(gpu: &Gpu, btf: &Btf, options: &Options) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let size = btf.size();
    let orders = [
        ("random", random_order(size, options.count)),
        ("raster", raster_order(size, options.count)),
    ];
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
    let options = options()?;
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
    if let Some(path) = &options.json {
        let text = serde_json::to_string_pretty(&rows).map_err(|error| error.to_string())?;
        std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
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
