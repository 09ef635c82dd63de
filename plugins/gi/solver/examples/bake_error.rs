//! How long the parts of a bake take, and how far its texels are from the truth.
//!
//! ```text
//! cargo run -p farlight_gi_solver --example bake_error -- SCENE.glb [--scale METRES] [--page N]
//!     [--rays N] [--times N [--every N]] [--texels N] [--paths N] [--bounces N] [--seed N] [--sky RADIANCE]
//!     [--lamp X,Y,Z,CANDELA] [--sun X,Y,Z,LUX] [--probes N]
//! ```
//! Gathers `--rays` rays a texel and compares them, raw and denoised, with `--times` times as many
//! (independent) rays at every `--every`-th texel, and `--texels` of the texels with the path tracer
//! (`--paths` paths each). CPU seconds are those of all threads: on a machine with other work they tell more
//! than the clock.

use std::{path::PathBuf, sync::Arc, time::Instant};

use farlight_gi_solver::{
    World,
    bake::{
        Density, DirectLight, Gathered, Gatherer, GathererSettings, Layout, LayoutSettings,
        denoise, direct, volume,
    },
    estimate::{GatherSettings, no_progress},
    import::{ImportOptions, load_scene},
    path::PathTracer,
    probe::gather_probes,
    receiver::Receiver,
    scene::{DirectSky, Light, LightId, LightKind, Sky},
    session::ProbeGrid,
    unwrap::{UnwrapOptions, ensure_uv1},
};
use glam::{Affine3A, Quat, UVec3, Vec3};
use rayon::prelude::*;

struct Arguments {
    words: Vec<String>,
}

impl Arguments {
    fn text(&self, name: &str) -> Option<&str> {
        let at = self.words.iter().position(|w| w == name)?;
        self.words.get(at + 1).map(String::as_str)
    }

    fn number(&self, name: &str, default: f32) -> f32 {
        self.text(name).and_then(|w| w.parse().ok()).unwrap_or(default)
    }

    fn four(&self, name: &str) -> Option<[f32; 4]> {
        let numbers: Vec<f32> =
            self.text(name)?.split(',').filter_map(|n| n.parse().ok()).collect();
        numbers.try_into().ok()
    }
}

/// Processor seconds of all threads so far (Linux; 0 elsewhere).
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}

fn timed<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let (clock, cpu) = (Instant::now(), cpu_seconds());
    let result = work();
    let (clock, cpu) = (clock.elapsed().as_secs_f64(), cpu_seconds() - cpu);
    println!("{what:<24} {cpu:8.2} CPU s   {clock:8.2} s");
    result
}

fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Median and 95th percentile.
fn percentiles(mut errors: Vec<f32>) -> (f32, f32) {
    errors.sort_by(f32::total_cmp);
    let at = |p: f32| errors.get((errors.len() as f32 * p) as usize).copied().unwrap_or(0.0);
    (at(0.5) * 100.0, at(0.95) * 100.0)
}

fn main() {
    let a = Arguments { words: std::env::args().skip(1).collect() };
    let path = PathBuf::from(a.words.first().expect("a scene"));
    let options = ImportOptions {
        scale: a.number("--scale", 1.0),
        range_window: true,
        ..ImportOptions::default()
    };
    let mut scene = load_scene(&path, &options).expect("a scene").scene;
    let page = a.number("--page", 256.0) as u32;
    timed("unwrap", || {
        for mesh in scene.meshes.values_mut() {
            let options = UnwrapOptions { texels: page, ..UnwrapOptions::default() };
            match ensure_uv1(mesh, &options) {
                Ok(unwrapped) => *mesh = Arc::new(unwrapped.apply(mesh)),
                Err(error) => println!("left out: {error}"),
            }
        }
    });
    if let Some([x, y, z, candela]) = a.four("--lamp") {
        let light = Light {
            kind: LightKind::Point,
            position: Vec3::new(x, y, z),
            direction: Vec3::NEG_Y,
            intensity: Vec3::splat(candela),
            range: 20.0,
        };
        scene.lights.insert(LightId(u64::MAX), light);
    }
    if let Some([x, y, z, lux]) = a.four("--sun") {
        let light = Light {
            kind: LightKind::Directional,
            position: Vec3::ZERO,
            direction: Vec3::new(x, y, z).normalize(),
            intensity: Vec3::splat(lux),
            range: f32::INFINITY,
        };
        scene.lights.insert(LightId(u64::MAX - 1), light);
    }
    if let Some(sky) = a.text("--sky").and_then(|s| s.parse().ok()) {
        scene.sky = Sky::Constant(Vec3::splat(sky));
    }
    let world = timed("world", || World::new(&scene));
    let settings = LayoutSettings { page_size: page, max_pages: 1, density: Density::Fit };
    let receivers: Vec<_> = scene.instances.keys().copied().collect();
    let layout = timed("layout", || Layout::new(&scene, &world, receivers, &settings));
    println!(
        "{} texels ({:.0} % of {page}x{page}), {:.1} a metre, {} triangles, {} receivers, {} refused",
        layout.len(),
        100.0 * layout.len() as f32 / (page * page) as f32,
        layout.texels_per_metre,
        world.triangle_count(),
        layout.placements.len(),
        layout.refused.len()
    );
    let texels: Vec<_> = layout.texels().collect();
    let closed = texels.iter().filter(|t| !t.open).count();
    println!("{closed} of them enclosed");
    let (low, high) = texels
        .iter()
        .filter(|t| t.open)
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), t| {
            (low.min(t.position), high.max(t.position))
        });
    println!("from {low} to {high}");
    let lights: Vec<_> =
        world.lights.iter().map(|&light| DirectLight { light, radius: 0.0 }).collect();
    timed("direct", || direct(&world, &layout, &lights, no_progress()));
    let settings = |seed| GathererSettings {
        seed,
        bounces: a.number("--bounces", 0.0) as u32,
        direct_sky: DirectSky::Included,
    };
    let seed = a.number("--seed", 1.0) as u64;
    let gatherer = timed("prepare", || {
        Gatherer::new(&world, &layout, settings(seed), no_progress()).expect("not stopped")
    });
    let rays = a.number("--rays", 64.0) as u32;
    let mut gathered = Gathered::new(&layout);
    let cpu = cpu_seconds();
    timed("gather", || gatherer.pass(&mut gathered, rays, no_progress()));
    println!("{:.2} us a ray", (cpu_seconds() - cpu) * 1e6 / f64::from(rays) / layout.len() as f64);
    println!("estimated error          {:.2} %", gathered.relative_error(&layout) * 100.0);

    let times = a.number("--times", 0.0) as u32;
    let brightest =
        (0..layout.len()).map(|i| luminance(gathered.irradiance(i))).fold(0.0, f32::max);
    if times > 0 {
        let other = Gatherer::new(&world, &layout, settings(seed + 77), no_progress()).unwrap();
        let every = a.number("--every", 1.0).max(1.0) as usize;
        let chosen: Vec<usize> = (every / 2..layout.len()).step_by(every).collect();
        let reference: Vec<f32> = timed("reference", || {
            chosen.par_iter().map(|&i| luminance(other.irradiance(i, rays * times))).collect()
        });
        let filtered = timed("denoise", || denoise(&layout, &gathered));
        let compare = |what: &str, of: &dyn Fn(usize) -> Vec3| {
            let lit = chosen.iter().zip(&reference);
            let lit = lit.filter(|(i, truth)| texels[**i].open && **truth > brightest * 1e-3);
            let error = |(&i, &truth): (&usize, &f32)| (luminance(of(i)) - truth).abs() / truth;
            let (median, high) = percentiles(lit.map(error).collect());
            println!("{what} against {times}x    median {median:.2} %, p95 {high:.2} %");
        };
        compare("raw", &|i| gathered.irradiance(i));
        compare("denoised", &|i| filtered[i]);
    }

    let count = a.number("--texels", 0.0) as usize;
    if count > 0 {
        let tracer = PathTracer::new(&world);
        let paths = GatherSettings { paths: a.number("--paths", 4096.0) as u32, seed: seed + 5 };
        let flat: Vec<usize> = (0..layout.len())
            .filter(|&i| texels[i].open && texels[i].normal == texels[i].geometric)
            .collect();
        let chosen: Vec<usize> =
            (0..count).map(|k| flat[(k * 2 + 1) * flat.len() / (2 * count)]).collect();
        let truth: Vec<_> = timed("path tracer", || {
            chosen
                .par_iter()
                .map(|&i| {
                    let receiver =
                        Receiver { position: texels[i].position, normal: texels[i].geometric };
                    let light = receiver.gather(&tracer, &paths, i as u64, no_progress()).unwrap();
                    let sky = light.direct.mean - receiver.direct(&world);
                    let mean = if paths.paths > 0 && settings(1).bounces == 1 {
                        light.one_bounce.mean
                    } else {
                        light.indirect.mean
                    };
                    (luminance(mean + sky), luminance(light.indirect.se + light.direct.se))
                })
                .collect()
        });
        let mut signed = 0.0;
        let (mut z_sum, mut z_squares, mut n) = (0.0, 0.0, 0.0_f32);
        let (mut sum_ours, mut sum_truth, mut sum_variance) = (0.0, 0.0, 0.0);
        let mut errors = Vec::new();
        for (&i, &(truth, se)) in chosen.iter().zip(&truth) {
            if truth < brightest * 1e-3 {
                continue;
            }
            let ours = luminance(gathered.irradiance(i));
            let noise = luminance(gathered.difference(i).abs());
            let z = (ours - truth) / se.hypot(noise);
            z_sum += z;
            z_squares += z * z;
            n += 1.0;
            signed += (ours - truth) / truth;
            sum_ours += ours;
            sum_truth += truth;
            sum_variance += se * se + noise * noise;
            errors.push((ours - truth).abs() / truth);
        }
        let (median, high) = percentiles(errors);
        println!(
            "against paths            median {median:.2} %, p95 {high:.2} %, mean {:+.2} %, sum {:+.3} % \
             (+- {:.3} %), {n} texels",
            signed / n * 100.0,
            (sum_ours / sum_truth - 1.0) * 100.0,
            sum_variance.sqrt() / sum_truth * 100.0,
        );
        println!(
            "z (few degrees of freedom) mean {:.3} rms {:.3}",
            z_sum / n,
            (z_squares / n).sqrt()
        );
    }

    let probes = a.number("--probes", 0.0);
    if probes > 0.0 {
        let size = high - low;
        let spacing = (size.x * size.y * size.z / probes).cbrt();
        let resolution = (size / spacing).ceil().as_uvec3().max(UVec3::ONE);
        let transform = Affine3A::from_scale_rotation_translation(
            size * 0.98,
            Quat::IDENTITY,
            (low + high) * 0.5,
        );
        let grid = ProbeGrid { transform, resolution };
        println!("{resolution} probes");
        let ours = timed("volume", || volume(&world, &gatherer, &grid, 1024, no_progress()));
        let positions: Vec<Vec3> = (0..resolution.element_product())
            .step_by(16)
            .map(|i| {
                let at = UVec3::new(
                    i % resolution.x,
                    i / resolution.x % resolution.y,
                    i / (resolution.x * resolution.y),
                );
                let cell = (at.as_vec3() + 0.5) / resolution.as_vec3() - 0.5;
                transform.transform_point3(cell)
            })
            .collect();
        let settings = GatherSettings { paths: 1024, seed: 3 };
        let truth = timed("gather_probes, 1 of 16", || {
            gather_probes(&world, &positions, &settings, no_progress())
        });
        let (ours, truth) = (ours.unwrap(), truth.unwrap());
        let errors = truth.iter().enumerate().map(|(k, t)| {
            let t = luminance((t.indirect + t.sky).0[0]);
            (luminance(ours[k * 16].0[0]) - t).abs() / t.max(1e-9)
        });
        let (median, high) = percentiles(errors.collect());
        println!("probes against paths     median {median:.2} %, p95 {high:.2} %");
    }
}
