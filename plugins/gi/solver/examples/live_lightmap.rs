//! The live lightmap without a window: a light moves through a scene, stops, and doubles; what the
//! session answers is timed and compared with the path tracer.
//!
//! ```text
//! cargo run -p farlight_gi_solver --example live_lightmap -- [SCENE.glb] [--page N] [--rays N]
//!     [--frames N] [--samples N] [--paths N] [--threads N] [--light X,Y,Z,CANDELA]
//!     [--sky RADIANCE] [--scale METRES] [--out DIR]
//! ```
//! Without a scene two rooms with a doorway are lit. `--samples` texels are compared, with `--paths`
//! paths each. With `--out` the atlas is written as PNG, tone-mapped.

#[path = "../tests/common/mod.rs"]
mod common;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use farlight_gi_solver::{
    SceneChange,
    estimate::{GatherSettings, no_progress},
    import::{ImportOptions, load_scene},
    scene::{Light, LightId, Sky},
    session::{
        GridId, LightingUpdate, ProbeGrid, Session, SessionChange, SessionSettings, SnapshotId,
        reference,
    },
    unwrap::{UnwrapOptions, ensure_uv1},
};
use glam::{Affine3A, Quat, UVec3, Vec3};

struct Arguments {
    scene: Option<PathBuf>,
    page: u32,
    rays: u32,
    frames: u32,
    samples: usize,
    paths: u32,
    threads: usize,
    out: Option<PathBuf>,
    /// Position and intensity, for scenes without a light.
    light: Option<[f32; 4]>,
    /// Radiance of a constant sky.
    sky: Option<f32>,
    /// Metres a unit of the file.
    scale: f32,
}

fn arguments() -> Arguments {
    let mut a = Arguments {
        scene: None,
        page: 128,
        rays: 1024,
        frames: 60,
        samples: 200,
        paths: 16384,
        threads: 1,
        out: None,
        light: None,
        sky: None,
        scale: 1.0,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        if word == "--light" {
            let numbers = words.next().unwrap_or_default();
            let numbers: Vec<f32> = numbers.split(',').filter_map(|n| n.parse().ok()).collect();
            a.light = numbers.try_into().ok();
            continue;
        }
        if word == "--sky" || word == "--scale" {
            let value = words.next().and_then(|w| w.parse().ok());
            if word == "--sky" {
                a.sky = value;
            } else {
                a.scale = value.unwrap_or(1.0);
            }
            continue;
        }
        let mut number = || words.next().and_then(|w| w.parse().ok()).expect("a number");
        match word.as_str() {
            "--page" => a.page = number(),
            "--rays" => a.rays = number(),
            "--frames" => a.frames = number(),
            "--samples" => a.samples = number() as usize,
            "--paths" => a.paths = number(),
            "--threads" => a.threads = number() as usize,
            "--out" => a.out = words.next().map(PathBuf::from),
            _ => a.scene = Some(word.into()),
        }
    }
    a
}

/// The file's scene, with second UV sets where there are none.
fn load(path: &Path, scale: f32) -> Vec<SessionChange> {
    let options = ImportOptions { scale, ..ImportOptions::default() };
    let imported = load_scene(path, &options).expect("a readable scene");
    let mut scene = imported.scene;
    for mesh in scene.meshes.values_mut().filter(|mesh| mesh.uv1.is_empty()) {
        let unwrapped = ensure_uv1(mesh, &UnwrapOptions::default()).expect("an unwrappable mesh");
        *mesh = Arc::new(unwrapped.apply(mesh));
    }
    let mut changes: Vec<_> = scene.changes().map(SessionChange::Scene).collect();
    changes.extend(scene.instances.keys().map(|id| SessionChange::AddReceiver(*id)));
    changes
}

/// The pages as a client holds them.
#[derive(Default)]
struct Client {
    pages: BTreeMap<u32, Vec<Vec3>>,
    page_size: u32,
    bytes: usize,
}

impl Client {
    fn take(&mut self, update: &LightingUpdate) {
        let n = self.page_size;
        for tile in &update.tiles {
            self.bytes += tile.texels.len() * 8;
            let page =
                self.pages.entry(tile.page.0).or_insert_with(|| vec![Vec3::ZERO; (n * n) as usize]);
            for (i, texel) in tile.texels.iter().enumerate() {
                let (x, y) = (i as u32 % tile.rect.width, i as u32 / tile.rect.width);
                page[((tile.rect.y + y) * n + tile.rect.x + x) as usize] = *texel;
            }
        }
    }

    fn write(&self, folder: &Path, name: &str, scale: f32) {
        for (index, page) in &self.pages {
            let n = self.page_size;
            let zoom = (1024 / n).max(1);
            let image = image::RgbImage::from_fn(n * zoom, n * zoom, |x, y| {
                let c = page[((y / zoom) * n + x / zoom) as usize] * scale;
                image::Rgb((c / (c + 1.0)).to_array().map(|v| (v.powf(1.0 / 2.2) * 255.0) as u8))
            });
            image.save(folder.join(format!("{name}-{index}.png"))).expect("a writable folder");
        }
    }
}

/// Quantiles of relative luminance errors over texels with at least 1 % of the largest value.
fn compare(session: &Session, client: &Client, a: &Arguments, label: &str) {
    let texels = session.texels();
    let stride = (texels.len() / a.samples).max(1);
    let chosen: Vec<_> = texels.iter().copied().skip(stride / 2).step_by(stride).collect();
    let settings = GatherSettings { paths: a.paths, seed: 99 };
    let truth = reference(session.scene(), &chosen, &settings, no_progress()).expect("all");
    let y = |c: Vec3| c.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let rows: Vec<(f32, f32, f32)> = chosen
        .iter()
        .zip(&truth)
        .map(|(t, truth)| {
            let page = &client.pages[&t.page.0];
            let shown = page[(t.y * client.page_size + t.x) as usize];
            (y(shown), y(truth.mean), y(truth.se))
        })
        .collect();
    let largest = rows.iter().map(|r| r.1).fold(0.0, f32::max);
    let lit: Vec<_> = rows.iter().filter(|r| r.1 > largest * 0.01).collect();
    let mut errors: Vec<f32> = lit.iter().map(|r| (r.0 - r.1).abs() / r.1).collect();
    errors.sort_by(f32::total_cmp);
    let mean = |f: &dyn Fn(&(f32, f32, f32)) -> f32| {
        lit.iter().map(|r| f(r)).sum::<f32>() / lit.len().max(1) as f32 * 100.0
    };
    let Some(end) = errors.len().checked_sub(1) else { return };
    let q = |p: f32| errors[(end as f32 * p) as usize] * 100.0;
    println!(
        "{label}: error median {:.2} %, 95th {:.2} %, max {:.1} %, mean signed {:+.2} % over {} \
         texels (reference noise {:.2} %)",
        q(0.5),
        q(0.95),
        q(1.0),
        mean(&|r| (r.0 - r.1) / r.1),
        errors.len(),
        mean(&|r| r.2 / r.1),
    );
}

/// CPU time of all threads of this process so far, in milliseconds; 0 where there is no /proc.
fn cpu_milliseconds() -> f64 {
    let Ok(tasks) = std::fs::read_dir("/proc/self/task") else { return 0.0 };
    let nanoseconds = tasks.flatten().filter_map(|task| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse::<f64>().ok()
    });
    nanoseconds.sum::<f64>() / 1e6
}

fn milliseconds(d: Duration) -> f64 {
    d.as_secs_f64() * 1e3
}

fn print_spread(name: &str, times: &mut [f64]) {
    times.sort_by(f64::total_cmp);
    let at = |p: f64| times[((times.len() - 1) as f64 * p) as usize];
    println!("{name}: median {:.1}, 95th {:.1}, max {:.1} ms", at(0.5), at(0.95), at(1.0));
}

fn scene(a: &Arguments) -> Vec<SessionChange> {
    let mut changes = match &a.scene {
        Some(path) => {
            let mut changes = load(path, a.scale);
            if let Some(sky) = a.sky {
                let sky = Sky::Constant(Vec3::splat(sky));
                changes.push(SessionChange::Scene(SceneChange::SetSky(sky)));
            }
            if let Some([x, y, z, i]) = a.light {
                changes.push(common::set_light(0, Vec3::new(x, y, z), Vec3::splat(i)));
            }
            changes
        }
        None => {
            let mut b = common::two_rooms(true);
            b.point_light(0, Vec3::new(2.0, 2.2, 1.2), Vec3::splat(30.0));
            b.changes
        }
    };
    changes.push(SessionChange::SetGrid(
        GridId(0),
        ProbeGrid {
            transform: Affine3A::from_scale_rotation_translation(
                Vec3::new(8.2, 2.8, 3.8),
                Quat::IDENTITY,
                Vec3::new(4.1, 1.5, 2.0),
            ),
            resolution: UVec3::new(8, 3, 4),
        },
    ));
    changes
}

fn main() {
    let a = arguments();
    let mut session = Session::new(SessionSettings {
        page_size: a.page,
        max_pages: 1,
        texels_per_metre: 32.0,
        rays_per_texel: a.rays,
        threads: a.threads,
        ..Default::default()
    });
    let mut client = Client { page_size: a.page, ..Default::default() };
    session.apply(SnapshotId(1), scene(&a));
    let write = |client: &Client, name: &str| {
        if let Some(folder) = &a.out {
            std::fs::create_dir_all(folder).expect("a writable folder");
            client.write(folder, name, 1.0);
        }
    };

    // From nothing.
    let mut elapsed = Duration::ZERO;
    let (mut step_times, mut first) = (Vec::new(), true);
    while !session.is_idle() && elapsed < Duration::from_secs(60) {
        let t = Instant::now();
        let update = session.step();
        elapsed += t.elapsed();
        step_times.push(milliseconds(t.elapsed()));
        if let Some(update) = update {
            client.take(&update);
            let e = milliseconds(elapsed);
            if !update.tiles.is_empty() || update.quality.converged {
                println!("{e:8.1} ms: {} tiles, {:?}", update.tiles.len(), update.quality);
            }
            if first {
                first = false;
                write(&client, "first");
                compare(&session, &client, &a, "first answer");
            }
        }
    }
    println!("{} texels, {} kept rays", session.texels().len(), session.rays_traced());
    print_spread("steps while growing", &mut step_times);
    compare(&session, &client, &a, "still");
    write(&client, "still");

    // A light that moves at 0.5 m/s, 30 frames a second.
    let Some((&light_id, &light)) = session.scene().lights.iter().next() else { return };
    let place = |frame: u32| Light {
        position: light.position + Vec3::new(0.0, -0.2, 1.0) * (0.5 * frame as f32 / 30.0),
        ..light
    };
    let mut snapshot = 1;
    let mut change = |session: &mut Session, id: LightId, light: Light| {
        snapshot += 1;
        let change = SessionChange::Scene(SceneChange::SetLight(id, light));
        session.apply(SnapshotId(snapshot), vec![change]);
    };
    let (mut times, mut cpu_times) = (Vec::new(), Vec::new());
    client.bytes = 0;
    for frame in 0..a.frames {
        let (t, cpu) = (Instant::now(), cpu_milliseconds());
        change(&mut session, light_id, place(frame));
        for _ in 0..100 {
            if let Some(update) = session.step() {
                client.take(&update);
                break;
            }
        }
        times.push(milliseconds(t.elapsed()));
        cpu_times.push(cpu_milliseconds() - cpu);
    }
    print_spread("update for a moved light", &mut times);
    print_spread("  its CPU time on all threads", &mut cpu_times);
    println!("{:.0} KB an update", client.bytes as f64 / f64::from(a.frames) / 1e3);
    compare(&session, &client, &a, "moving, same instant");
    write(&client, "moving");

    // The light doubles.
    let doubled = Light { intensity: light.intensity * 2.0, ..place(a.frames) };
    let t = Instant::now();
    change(&mut session, light_id, doubled);
    while !session.is_idle() {
        if let Some(update) = session.step() {
            client.take(&update);
            println!("intensity doubled: answered after {:.1} ms", milliseconds(t.elapsed()));
            break;
        }
    }
    compare(&session, &client, &a, "first answer to that");
    let t = Instant::now();
    while !session.is_idle() && t.elapsed() < Duration::from_secs(2) {
        if let Some(update) = session.step() {
            client.take(&update);
        }
    }
    compare(&session, &client, &a, "2 s later");
    write(&client, "stopped");
}
