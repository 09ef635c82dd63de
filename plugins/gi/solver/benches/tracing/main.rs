//! Rays a second of the tracer, beside Embree where it is installed, and on demand beside obvhs.
//!
//! `cargo bench -p farlight_gi_solver --bench tracing -- [OPTIONS]`
//!
//! - `--scene FILE.glb`, `--scale S`: without them `scenes/hotel-room.glb` of the folder in
//!   `FARLIGHT_TEST_DATA`, in millimetres, or a generated room.
//! - `--rounds N`, `--fastest`: one thread; both tracers answer the same rays in slices of 8192 that
//!   alternate. Each slice counts with its median over the rounds or, for a busy machine, with its
//!   minimum.
//! - `--embree-high`: Embree builds at high instead of medium quality.
//! - `--obvhs`: compare with obvhs, too.
//! - `--json FILE`: the same figures for programs.

mod embree;
mod obvhs_peer;
mod rays;
mod scene;

use std::{path::PathBuf, process::ExitCode, time::Instant};

use farlight_gi_solver::tracer::{Hit, Ray, Tracer};
use serde::Serialize;

use embree::{Embree, Quality};

/// Rays between two looks at the clock.
const SLICE: usize = 8192;

/// A tracer to compare with.
trait Peer {
    fn name(&self) -> String;
    /// Distance of the closest hit, or infinity.
    fn closest(&self, ray: &Ray) -> f32;
    /// Whether anything lies on the segment.
    fn occluded(&self, ray: &Ray) -> bool;
}

#[derive(Serialize)]
struct Report {
    scene: String,
    triangles: usize,
    build_ms: f64,
    bytes: usize,
    tables: Vec<Table>,
}

/// One comparison.
#[derive(Serialize)]
struct Table {
    peer: Option<String>,
    peer_build_ms: Option<f64>,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    rays: &'static str,
    query: &'static str,
    count: usize,
    mrays_per_s: f64,
    peer_mrays_per_s: Option<f64>,
    ratio: Option<f64>,
    /// Share of rays that hit.
    hits: f64,
    /// Rays whose answers differ: one hits and the other misses, or the distances differ by more
    /// than 1e-4 of themselves.
    different: Option<usize>,
}

struct Options {
    scene: Option<PathBuf>,
    scale: f32,
    rounds: usize,
    json: Option<PathBuf>,
    high: bool,
    obvhs: bool,
    fastest: bool,
}

/// How many, and whether the fastest counts.
type Rounds = (usize, bool);

fn options() -> Result<Options, String> {
    let data = std::env::var_os("FARLIGHT_TEST_DATA").map(PathBuf::from);
    let mut options = Options {
        scene: data.map(|d| d.join("scenes/hotel-room.glb")).filter(|p| p.is_file()),
        scale: 0.001,
        rounds: 9,
        json: None,
        high: false,
        obvhs: false,
        fastest: false,
    };
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg} needs a value"));
        match arg.as_str() {
            "--bench" => {} // cargo's own
            "--scene" => options.scene = Some(value()?.into()),
            "--scale" => options.scale = value()?.parse().map_err(|e| format!("--scale: {e}"))?,
            "--rounds" => {
                options.rounds = value()?.parse().map_err(|e| format!("--rounds: {e}"))?;
            }
            "--json" => options.json = Some(value()?.into()),
            "--fastest" => options.fastest = true,
            "--embree-high" => options.high = true,
            "--obvhs" => options.obvhs = true,
            _ => return Err(format!("unknown argument {arg}")),
        }
    }
    Ok(options)
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("tracing: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), String> {
    let options = options()?;
    let (name, triangles) = match &options.scene {
        Some(path) => (path.display().to_string(), scene::load(path, options.scale)?),
        None => {
            println!(
                "no scene: FARLIGHT_TEST_DATA doesn't hold scenes/hotel-room.glb; a generated room stands in"
            );
            ("generated room".into(), scene::generated())
        }
    };
    let (tracer, build_ms) = timed(|| Tracer::new(&triangles));
    println!("{name}: {} triangles", triangles.len());
    println!("build {build_ms:.1} ms, {:.1} MB", tracer.memory() as f64 / 1e6);
    let sets = rays::Sets::new(&tracer, &triangles);
    let rounds = (options.rounds, options.fastest);
    let quality = if options.high { Quality::High } else { Quality::Medium };
    let mut tables = Vec::new();
    match Embree::load() {
        Ok(library) => {
            let peer = timed(|| library.scene(&triangles, quality));
            tables.push(table(&tracer, &sets, Some(peer), rounds));
        }
        Err(reason) => {
            println!("Embree SKIPPED, so there is nothing to compare with: {reason}");
            tables.push(table(&tracer, &sets, None::<(embree::Scene<'_>, f64)>, rounds));
        }
    }
    if options.obvhs {
        let peer = timed(|| obvhs_peer::Obvhs::new(&triangles));
        tables.push(table(&tracer, &sets, Some(peer), rounds));
    }
    let report = Report {
        scene: name,
        triangles: triangles.len(),
        build_ms,
        bytes: tracer.memory(),
        tables,
    };
    if let Some(path) = options.json {
        let text = serde_json::to_string_pretty(&report).map_err(|e| e.to_string())?;
        std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

/// A result and how many milliseconds it took.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64() * 1e3)
}

/// Measures and prints.
fn table<P: Peer>(
    tracer: &Tracer,
    sets: &rays::Sets,
    peer: Option<(P, f64)>,
    rounds: Rounds,
) -> Table {
    let other = peer.as_ref().map(|p| &p.0);
    let rows = vec![
        closest("coherent", &sets.camera, tracer, other, rounds),
        closest("incoherent", &sets.bounce, tracer, other, rounds),
        occluded("incoherent", &sets.bounce, tracer, other, rounds),
        occluded("shadow segments", &sets.shadow, tracer, other, rounds),
    ];
    if let Some((peer, ms)) = &peer {
        println!("\nbeside {}, build {ms:.1} ms", peer.name());
    }
    println!(
        "{:<16} {:<8} {:>8} {:>7} {:>10} {:>10} {:>7} {:>10}",
        "rays", "query", "count", "hits", "Mrays/s", "peer", "ratio", "different"
    );
    let number = |x: Option<f64>| x.map_or("-".into(), |x| format!("{x:.2}"));
    for row in &rows {
        println!(
            "{:<16} {:<8} {:>8} {:>6.1}% {:>10.2} {:>10} {:>7} {:>10}",
            row.rays,
            row.query,
            row.count,
            row.hits * 100.0,
            row.mrays_per_s,
            number(row.peer_mrays_per_s),
            number(row.ratio),
            row.different.map_or("-".into(), |n| n.to_string()),
        );
    }
    Table {
        peer: peer.as_ref().map(|p| p.0.name()),
        peer_build_ms: peer.as_ref().map(|p| p.1),
        rows,
    }
}

/// Times both tracers on the same slices in turn; seconds for all rays, by slice medians (or, for
/// a busy machine, minima).
fn time(
    rays: &[Ray],
    (rounds, fastest): Rounds,
    mut ours: impl FnMut(usize, &[Ray]),
    mut theirs: Option<impl FnMut(usize, &[Ray])>,
) -> (f64, Option<f64>) {
    let slices = rays.len().div_ceil(SLICE);
    let mut times = vec![[Vec::new(), Vec::new()]; slices];
    for round in 0..=rounds {
        for (i, slice) in rays.chunks(SLICE).enumerate() {
            let start = Instant::now();
            ours(i * SLICE, slice);
            let middle = Instant::now();
            if let Some(theirs) = &mut theirs {
                theirs(i * SLICE, slice);
            }
            // The first round warms the caches.
            if round > 0 {
                times[i][0].push((middle - start).as_secs_f64());
                times[i][1].push(middle.elapsed().as_secs_f64());
            }
        }
    }
    let mut sum = [0.0; 2];
    for slice in &mut times {
        for (sum, times) in sum.iter_mut().zip(slice) {
            times.sort_by(f64::total_cmp);
            *sum += times[if fastest { 0 } else { times.len() / 2 }];
        }
    }
    (sum[0], theirs.is_some().then_some(sum[1]))
}

fn closest(
    name: &'static str,
    rays: &[Ray],
    tracer: &Tracer,
    peer: Option<&impl Peer>,
    rounds: Rounds,
) -> Row {
    let mut ours = vec![Hit::NONE; rays.len()];
    let mut theirs = vec![f32::INFINITY; rays.len()];
    let (a, b) = time(
        rays,
        rounds,
        |first, rays| {
            for (ray, hit) in rays.iter().zip(&mut ours[first..]) {
                *hit = tracer.closest(ray);
            }
        },
        peer.map(|peer| {
            let theirs = &mut theirs;
            move |first: usize, rays: &[Ray]| {
                for (ray, t) in rays.iter().zip(&mut theirs[first..]) {
                    *t = peer.closest(ray);
                }
            }
        }),
    );
    let differs = |(hit, t): (&Hit, &f32)| {
        hit.is_hit() != t.is_finite()
            || (hit.is_hit() && (hit.t - t).abs() > 1e-4 * hit.t.abs().max(1e-2))
    };
    Row {
        rays: name,
        query: "closest",
        count: rays.len(),
        mrays_per_s: rays.len() as f64 / a / 1e6,
        peer_mrays_per_s: b.map(|b| rays.len() as f64 / b / 1e6),
        ratio: b.map(|b| b / a),
        hits: ours.iter().filter(|h| h.is_hit()).count() as f64 / rays.len() as f64,
        different: peer.map(|_| ours.iter().zip(&theirs).filter(|&pair| differs(pair)).count()),
    }
}

fn occluded(
    name: &'static str,
    rays: &[Ray],
    tracer: &Tracer,
    peer: Option<&impl Peer>,
    rounds: Rounds,
) -> Row {
    let mut ours = vec![false; rays.len()];
    let mut theirs = vec![false; rays.len()];
    let (a, b) = time(
        rays,
        rounds,
        |first, rays| {
            for (ray, blocked) in rays.iter().zip(&mut ours[first..]) {
                *blocked = tracer.occluded(ray);
            }
        },
        peer.map(|peer| {
            let theirs = &mut theirs;
            move |first: usize, rays: &[Ray]| {
                for (ray, blocked) in rays.iter().zip(&mut theirs[first..]) {
                    *blocked = peer.occluded(ray);
                }
            }
        }),
    );
    Row {
        rays: name,
        query: "any",
        count: rays.len(),
        mrays_per_s: rays.len() as f64 / a / 1e6,
        peer_mrays_per_s: b.map(|b| rays.len() as f64 / b / 1e6),
        ratio: b.map(|b| b / a),
        hits: ours.iter().filter(|&&h| h).count() as f64 / rays.len() as f64,
        different: peer.map(|_| ours.iter().zip(&theirs).filter(|(a, b)| a != b).count()),
    }
}
