//! Evaluations a second on one core, one at a time and in vectors.
//!
//! `cargo bench -p farlight_btf_codec --bench evaluate -- [OPTIONS] [MATERIAL ...]`
//!
//! Without materials: those of the folder in `FARLIGHT_TEST_DATA` and those that the suite ships.
//!
//! - `--rounds N` (default 9): all backends answer the same queries in turn, slice by slice; each slice
//!   counts with its median over the rounds or, with `--fastest` for a busy machine, with its minimum.
//! - `--count N` (default 1048576): queries in a round.
//! - `--json FILE`: the same figures for programs.

mod support;

use std::process::ExitCode;
use std::time::Instant;

use farlight_btf_codec::{Backend, Btf, Query, Rules};
use glam::Vec3;
use serde::Serialize;
use support::{Options, random, raster};

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
    let options = Options::from_args(1 << 20)?;
    let mut rows = Vec::new();
    println!("{} evaluations on one core, million/s", options.count);
    let backends = Backend::available();
    print!("{:<12} {:>9} {:>9} {:<7}", "material", "texels", "bytes", "order");
    for backend in &backends {
        print!(" {:>8}", format!("{backend:?}"));
    }
    println!(" {:>7}", "ratio");
    for btf in options.open() {
        let [width, height] = btf.size();
        let orders = [
            ("random", random(btf.size(), options.count)),
            ("raster", raster(btf.size(), options.count)),
        ];
        for (order, queries) in orders {
            let speeds = time(&btf, &backends, &queries, &options);
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
    options.write(&rows)
}

/// Evaluations a second of each backend.
fn time(btf: &Btf, backends: &[Backend], queries: &[Query], options: &Options) -> Vec<f64> {
    let mut values = vec![Vec3::ZERO; SLICE];
    let mut times = vec![vec![Vec::new(); queries.len().div_ceil(SLICE)]; backends.len()];
    for round in 0..=options.rounds {
        for (at, slice) in queries.chunks(SLICE).enumerate() {
            for (backend, times) in backends.iter().zip(&mut times) {
                let values = &mut values[..slice.len()];
                let start = Instant::now();
                btf.evaluate_batch_on(*backend, slice, Rules::SHADING, values);
                std::hint::black_box(values);
                // The first round warms the caches.
                if round > 0 {
                    times[at].push(start.elapsed().as_secs_f64());
                }
            }
        }
    }
    let all = |slices: &mut Vec<Vec<f64>>| -> f64 {
        slices.iter_mut().map(|times| options.chosen(times)).sum()
    };
    times.iter_mut().map(|slices| queries.len() as f64 / all(slices)).collect()
}
