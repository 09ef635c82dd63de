//! Evaluations a second on one core, one at a time and in vectors.
//!
//! `cargo bench -p farlight_btf_codec --bench evaluate -- [OPTIONS] [MATERIAL ...]`
//!
//! Without materials: those of the folder in `FARLIGHT_TEST_DATA` and those that the suite ships.
//!
//! - `--rounds N` (default 9): all backends answer the same queries in turn, slice by slice; each slice
//!   counts with its median over the rounds or, with `--fastest` for a busy machine, with its minimum.
//! - `--json FILE`: the same figures for programs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use farlight_btf_codec::{Angles, Backend, Btf, BtfError, Query, Rules, read};
use glam::Vec3;
use serde::Serialize;

/// Queries in a test.
const COUNT: usize = 1 << 20;
/// Queries between two looks at the clock.
const SLICE: usize = 1 << 13;

#[derive(Serialize)]
struct Row {
    material: String,
    texels: [u32; 2],
    bytes: usize,
    order: &'static str,
    backend: Backend,
    evaluations_per_s: f64,
}

#[derive(Default)]
struct Options {
    materials: Vec<PathBuf>,
    rounds: usize,
    fastest: bool,
    json: Option<PathBuf>,
}

fn options() -> Result<Options, String> {
    let mut options = Options { rounds: 9, ..Options::default() };
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg} needs a value"));
        match arg.as_str() {
            "--bench" => {} // cargo's own
            "--rounds" => {
                options.rounds = value()?.parse().map_err(|e| format!("--rounds: {e}"))?;
            }
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
        Some(data) => folders.push(PathBuf::from(data).join("btfbase")),
        None => println!("measured materials SKIPPED: FARLIGHT_TEST_DATA is not set"),
    }
    let mut found: Vec<PathBuf> = (folders.iter())
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flat_map(|entries| entries.flatten().map(|entry| entry.path()))
        .filter(|path| path.is_dir() || path.extension().is_some_and(|e| e == "fbtf"))
        .collect();
    found.sort();
    found
}

fn open(path: &Path) -> Result<Btf, BtfError> {
    match read::open(path, &read::Options::default())? {
        read::Material::Tables(btf) => Ok(btf),
        read::Material::Images(_) => Err(BtfError::Unsupported("pictures, not tables".to_owned())),
    }
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("evaluate: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), String> {
    let options = options()?;
    let mut rows = Vec::new();
    println!("{} evaluations on one core, million/s", COUNT);
    let backends = Backend::available();
    print!("{:<12} {:>9} {:>9} {:<7}", "material", "texels", "bytes", "order");
    for backend in &backends {
        print!(" {:>8}", format!("{backend:?}"));
    }
    println!(" {:>7}", "ratio");
    for path in &options.materials {
        let btf = match open(path) {
            Ok(btf) => btf,
            Err(error) => {
                println!("{} SKIPPED: {error}", path.display());
                continue;
            }
        };
        for (order, queries) in [("random", random(&btf)), ("raster", raster(&btf))] {
            let speeds = time(&btf, &backends, &queries, &options);
            let [width, height] = btf.size();
            let (name, bytes) = (&btf.info().name, 4 * btf.words().len());
            print!("{name:<12} {:>9} {bytes:>9} {order:<7}", format!("{width}x{height}"));
            for (backend, speed) in backends.iter().zip(&speeds) {
                print!(" {:>8.2}", speed / 1e6);
                rows.push(Row {
                    material: name.clone(),
                    texels: [width, height],
                    bytes,
                    order,
                    backend: *backend,
                    evaluations_per_s: *speed,
                });
            }
            println!(" {:>7.1}", speeds[speeds.len() - 1] / speeds[0]);
        }
    }
    if let Some(path) = &options.json {
        let text = serde_json::to_string_pretty(&rows).map_err(|e| e.to_string())?;
        std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

/// Evaluations a second of each backend.
fn time(btf: &Btf, backends: &[Backend], queries: &[Query], options: &Options) -> Vec<f64> {
    let mut values = vec![Vec3::ZERO; SLICE];
    let mut times = vec![vec![Vec::new(); queries.len() / SLICE]; backends.len()];
    for round in 0..=options.rounds {
        for (at, slice) in queries.chunks_exact(SLICE).enumerate() {
            for (backend, times) in backends.iter().zip(&mut times) {
                let start = Instant::now();
                btf.evaluate_batch_on(*backend, slice, Rules::SHADING, &mut values);
                std::hint::black_box(&values);
                // The first round warms the caches.
                if round > 0 {
                    times[at].push(start.elapsed().as_secs_f64());
                }
            }
        }
    }
    let chosen = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[if options.fastest { 0 } else { times.len() / 2 }]
    };
    times
        .iter_mut()
        .map(|slices| queries.len() as f64 / slices.iter_mut().map(chosen).sum::<f64>())
        .collect()
}

/// Random texels, both directions random over the hemisphere.
fn random(btf: &Btf) -> Vec<Query> {
    let [width, height] = btf.size();
    let mut state = 1_u32;
    let mut number = || {
        state = state.wrapping_add(0x9e37_79b9);
        let mut x = state;
        x = (x ^ x >> 16).wrapping_mul(0x21f0_aaad);
        x = (x ^ x >> 15).wrapping_mul(0x735a_2d97);
        ((x ^ x >> 15) >> 8) as f32 / (1 << 24) as f32
    };
    (0..COUNT)
        .map(|_| Query {
            x: (number() * width as f32) as i32,
            y: (number() * height as f32) as i32,
            angles: Angles {
                theta_i: number().acos(),
                phi_i: number() * std::f32::consts::TAU,
                theta_v: number().acos(),
                phi_v: number() * std::f32::consts::TAU,
            },
        })
        .collect()
}

/// Texel after texel, row after row, from the same directions.
fn raster(btf: &Btf) -> Vec<Query> {
    let width = btf.size()[0] as usize;
    let angles = Angles::from_degrees(40.0, 70.0, 25.0, 200.0);
    (0..COUNT).map(|at| Query { x: (at % width) as i32, y: (at / width) as i32, angles }).collect()
}
