//! What a scene and its light cost on the wire: the meshes and images once, then a lamp moves, and
//! every lighting update is encoded as the server would, beside plain half floats and LZ4 of these.
//!
//! ```text
//! cargo run -p farlight_wire --example lighting_bytes -- [SCENE.glb] [--page N] [--frames N]
//! ```
//! The scene is the demo's unless another is named. Pages have `--page` texels a side (128), the lamp
//! moves for `--frames` updates (60).

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use farlight_gi_solver::{
    SceneChange,
    import::{ImportOptions, load_scene},
    scene::{Light, LightId, LightKind},
    session::{
        GridId, LightingUpdate, ProbeGrid, Session, SessionChange, SessionSettings, SnapshotId,
    },
    unwrap::{UnwrapOptions, ensure_uv1},
};
use farlight_wire::{Blob, HalfGrid, HalfTile, LightingMessage, Limits, Piece};
use glam::{Affine3A, Quat, UVec3, Vec3};
use half::f16;

/// Where the lamp starts and ends, in metres.
const PATH: [Vec3; 2] = [Vec3::new(-4.2, 2.1, 0.9), Vec3::new(-1.5, 2.1, 0.6)];
/// Its intensity, candela.
const INTENSITY: Vec3 = Vec3::new(30.0, 28.0, 24.0);

struct Arguments {
    scene: PathBuf,
    page: u32,
    frames: u32,
}

fn arguments() -> Arguments {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let scene = here.join("../../../assets/scenes/doorway.glb");
    let mut a = Arguments { scene, page: 128, frames: 60 };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut number = || words.next().and_then(|w| w.parse().ok()).expect("a number");
        match word.as_str() {
            "--page" => a.page = number(),
            "--frames" => a.frames = number(),
            _ => a.scene = word.into(),
        }
    }
    a
}

/// Everything of the file, every mesh a receiver, and probes around all of it.
fn scene(path: &Path) -> Vec<SessionChange> {
    let mut scene = load_scene(path, &ImportOptions::default()).expect("a readable scene").scene;
    // The lamp is the only light.
    (scene.lights, scene.sky) = Default::default();
    for mesh in scene.meshes.values_mut().filter(|mesh| mesh.uv1.is_empty()) {
        let unwrapped = ensure_uv1(mesh, &UnwrapOptions::default()).expect("UVs");
        *mesh = Arc::new(unwrapped.apply(mesh));
    }
    let mut changes: Vec<_> = scene.changes().map(SessionChange::Scene).collect();
    changes.extend(scene.instances.keys().map(|id| SessionChange::AddReceiver(*id)));
    let (size, centre) = (Vec3::new(10.0, 3.0, 5.0), Vec3::new(0.0, 1.5, 0.0));
    let transform = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, centre);
    let grid = ProbeGrid { transform, resolution: UVec3::new(10, 4, 6) };
    changes.push(SessionChange::SetGrid(GridId(0), grid));
    changes
}

/// What the meshes and images of a scene cost, which are sent once.
fn print_blobs(changes: &[SessionChange]) {
    let blobs = changes.iter().filter_map(|change| match change {
        SessionChange::Scene(SceneChange::SetMesh(_, mesh)) => Some(Blob::Mesh(mesh.clone())),
        SessionChange::Scene(SceneChange::SetTexture(_, t)) => Some(Blob::Texture(t.clone())),
        _ => None,
    });
    let (mut count, mut memory, mut bytes) = (0, 0, 0);
    let mut times = [Duration::ZERO; 3];
    for blob in blobs {
        let (hash, hashing) = timed(|| blob.hash());
        let (encoded, encoding) = timed(|| blob.encode());
        let (decoded, decoding) = timed(|| Blob::decode(&encoded, hash, blob.memory()));
        decoded.expect("what was encoded");
        count += 1;
        memory += blob.memory();
        bytes += encoded.len();
        times = [times[0] + hashing, times[1] + encoding, times[2] + decoding];
    }
    let [hash, encode, decode] = times.map(|time| time.as_secs_f64() * 1e3);
    println!(
        "the scene: {count} meshes and images of {memory} bytes, {bytes} on the wire; hash {hash:.1}, \
         encode {encode:.1}, decode {decode:.1} ms",
    );
}

fn lamp(along: f32, brightness: f32) -> SessionChange {
    let light = Light {
        kind: LightKind::Point,
        position: PATH[0].lerp(PATH[1], along),
        direction: Vec3::NEG_Y,
        intensity: INTENSITY * brightness,
        range: f32::INFINITY,
    };
    SessionChange::Scene(SceneChange::SetLight(LightId(0), light))
}

/// What a client shows.
#[derive(Default)]
struct Shown {
    sequence: u64,
    pieces: HashMap<Piece, (u64, Vec<[u16; 3]>)>,
}

/// Sums over updates.
#[derive(Default)]
struct Sums {
    updates: usize,
    texels: usize,
    probes: usize,
    halves: usize,
    lz4: usize,
    ours: usize,
    /// Without looking at older messages.
    alone: usize,
    /// Of these, probes.
    our_probes: usize,
    encode: Vec<Duration>,
    decode: Vec<Duration>,
    largest_error: f32,
    error_sum: f64,
    errors: usize,
    largest_probe_error: f32,
}

/// The shortest of a few runs, so that other work on the machine counts less.
fn timed<T>(mut work: impl FnMut() -> T) -> (T, Duration) {
    let mut run = || {
        let start = Instant::now();
        let result = work();
        (result, start.elapsed())
    };
    let mut best = run();
    for _ in 0..4 {
        let (result, time) = run();
        best = (result, best.1.min(time));
    }
    best
}

impl Sums {
    /// `shown` is what the client has and acknowledged: all updates before.
    fn add(&mut self, update: &LightingUpdate, shown: &mut Shown) {
        shown.sequence += 1;
        let message = LightingMessage {
            sequence: shown.sequence,
            snapshot: update.snapshot,
            quality: update.quality,
            tiles: update.tiles.iter().map(HalfTile::new).collect(),
            grids: update.grids.iter().map(HalfGrid::new).collect(),
            ..Default::default()
        };
        let texels = message.tiles.iter().flat_map(|tile| &tile.texels).flatten();
        let probes = message.grids.iter().flat_map(|g| &g.probes).flatten().flatten();
        let halves: Vec<u8> = texels.chain(probes).flat_map(|bits| bits.to_le_bytes()).collect();
        let base = |piece| shown.pieces.get(&piece).map(|(n, values)| (*n, &values[..]));
        let ((bytes, _), encode) = timed(|| message.clone().encode_beside(base));
        let limits = Limits::default();
        let known =
            |piece, number| base(piece).filter(|(n, _)| *n == number).map(|(_, values)| values);
        let (decoded, decode) = timed(|| LightingMessage::decode_beside(&bytes, &limits, known));
        let decoded = decoded.expect("what was encoded");
        self.alone += message.encode().len();
        let only_probes = LightingMessage { tiles: Vec::new(), ..message.clone() };
        self.updates += 1;
        self.texels += message.tiles.iter().map(|tile| tile.texels.len()).sum::<usize>();
        self.probes += message.grids.iter().map(|grid| grid.probes.len()).sum::<usize>();
        self.halves += halves.len();
        self.lz4 += lz4_flex::block::compress(&halves).len();
        self.ours += bytes.len();
        self.our_probes += only_probes.encode_beside(base).0.len();
        self.encode.push(encode);
        self.decode.push(decode);
        self.compare(&message, &decoded);
        let tiles = decoded.tiles.into_iter().map(|tile| (tile.piece(), tile.texels));
        let runs = decoded.grids.into_iter().map(|g| (g.piece(), g.probes.into_flattened()));
        for (piece, values) in tiles.chain(runs) {
            shown.pieces.insert(piece, (message.sequence, values));
        }
    }

    /// Relative errors of texels; of probes beside the mean.
    fn compare(&mut self, sent: &LightingMessage, got: &LightingMessage) {
        let texels = |m: &LightingMessage| -> Vec<f32> {
            let bits = m.tiles.iter().flat_map(|tile| &tile.texels).flatten();
            bits.map(|bits| f16::from_bits(*bits).to_f32()).collect()
        };
        for (sent, got) in texels(sent).into_iter().zip(texels(got)) {
            // Below, halves themselves get coarser.
            if sent >= 6.2e-5 {
                let error = (got / sent - 1.0).abs();
                self.largest_error = self.largest_error.max(error);
                self.error_sum += f64::from(error);
                self.errors += 1;
            }
        }
        for (sent, got) in sent.grids.iter().zip(&got.grids) {
            for (sent, got) in sent.to_probes().zip(got.to_probes()) {
                for (a, b) in sent.0.iter().zip(got.0) {
                    let error =
                        ((*a - b).abs() / sent.0[0].abs().max(Vec3::splat(6.2e-5))).max_element();
                    self.largest_probe_error = self.largest_probe_error.max(error);
                }
            }
        }
    }

    fn print(&mut self, label: &str) {
        let n = self.updates.max(1);
        let ratio = |a: usize| a as f64 / self.ours.max(1) as f64;
        let (texels, probes) = (self.texels / n, self.probes / n);
        let (halves, lz4, ours) = (self.halves / n, self.lz4 / n, self.ours / n);
        println!("{label}: {} updates of {texels} texels and {probes} probes", self.updates);
        println!(
            "  bytes an update: halves {halves}, LZ4 {lz4}, ours {ours} ({} of probes; {} without what \
             is known): {:.2} times smaller than LZ4",
            self.our_probes / n,
            self.alone / n,
            ratio(self.lz4),
        );
        for (name, times) in [("encode", &mut self.encode), ("decode", &mut self.decode)] {
            times.sort_unstable();
            let Some(last) = times.len().checked_sub(1) else { continue };
            let ms = |at: usize| times[at].as_secs_f64() * 1e3;
            println!("  {name}: median {:.2}, most {:.2} ms", ms(last / 2), ms(last));
        }
        println!(
            "  relative error of texels: mean {:.3} %, largest {:.3} %; of probes beside their mean: \
             largest {:.3} %",
            self.error_sum / self.errors.max(1) as f64 * 100.0,
            self.largest_error * 100.0,
            self.largest_probe_error * 100.0,
        );
    }
}

fn main() {
    let a = arguments();
    let mut session = Session::new(SessionSettings {
        page_size: a.page,
        max_pages: 1,
        texels_per_metre: 32.0,
        ..Default::default()
    });
    let mut changes = scene(&a.scene);
    print_blobs(&changes);
    changes.push(lamp(0.0, 1.0));
    session.apply(SnapshotId(1), changes);
    let take = |sums: &mut Sums, shown: &mut Shown, update: LightingUpdate| {
        if !update.tiles.is_empty() || !update.grids.is_empty() {
            sums.add(&update, shown);
        }
    };
    let mut shown = Shown::default();
    let settle = |session: &mut Session, shown: &mut Shown, label: &str| {
        let (mut sums, start) = (Sums::default(), Instant::now());
        while !session.is_idle() && start.elapsed() < Duration::from_secs(60) {
            if let Some(update) = session.step() {
                take(&mut sums, shown, update);
            }
        }
        sums.print(label);
    };
    settle(&mut session, &mut shown, "from nothing until converged");
    let mut sums = Sums::default();
    for frame in 0..a.frames {
        let along = frame as f32 / a.frames as f32;
        session.apply(SnapshotId(2 + u64::from(frame)), vec![lamp(along, 1.0)]);
        while !session.is_idle() {
            if let Some(update) = session.step() {
                take(&mut sums, &mut shown, update);
                break;
            }
        }
    }
    sums.print("the lamp moves");
    session.apply(SnapshotId(1000), vec![lamp(1.0, 2.0)]);
    settle(&mut session, &mut shown, "the lamp doubles and stays");
}
