//! How much memory a client takes a frame: in allocations and bytes, over all of its threads. The
//! server is a process of its own.

#[path = "support/game.rs"]
mod game;

use std::{
    alloc::{GlobalAlloc, Layout, System},
    io::Read,
    net::Ipv4Addr,
    process::{Child, Command, Stdio},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use bevy::prelude::*;
use farlight::{
    gi::{
        BackendState, GiUpdate, LightingBackend,
        solver::session::{SessionChange, SnapshotId},
    },
    prelude::*,
};
use farlight_quic::{Authority, ListenConfig, QuicListener};
use farlight_server::{Server, ServerSettings};
use farlight_wire::Invitation;

use game::Game;

/// Frames that are measured.
const FRAMES: usize = 256;
/// Frames before them, on a scene that is still.
const WARM_UP: usize = 128;
/// Frames that are not counted: where the machine is busy with other things, one may be so long that
/// the work of many falls into it.
const OUTLIERS: usize = FRAMES / 50;
/// A frame.
const FRAME: Duration = Duration::from_millis(8);

/// What a frame of a still scene may take beyond one of the same game without the plugin:
/// allocations and bytes. The plugin's systems take about 25 and 3 KB (Bevy's own bookkeeping of
/// their parameters, mostly), a ping and its answer over QUIC, every other second, about 10 and 3 KB.
const STILL: (u64, u64) = (64, 16 << 10);
/// The same while the light moves. A frame may bring several updates, and each passes through a
/// few forms: bytes from the network, half floats, texels (32 KB for the whole page), and the copy that
/// goes to the GPU.
const MOVING: (u64, u64) = (400, 192 << 10);
/// The mean of all frames (the worst ones too) while the light moves; about 85 and 12 KB are taken.
const MOVING_MEAN: (f64, f64) = (250.0, 64.0 * 1024.0);

/// Where the server's process finds the path for its invitation; without it there is no server.
const INVITE: &str = "FARLIGHT_TEST_INVITE";

struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);
static BYTES: AtomicU64 = AtomicU64::new(0);

fn note(bytes: usize) {
    ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
    BYTES.fetch_add(bytes as u64, Ordering::Relaxed);
}

// SAFETY: it passes everything on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: the caller keeps the promises of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: the caller keeps the promises of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size.saturating_sub(layout.size()));
        // SAFETY: the caller keeps the promises of `realloc`.
        unsafe { System.realloc(old, layout, size) }
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the promises of `dealloc`.
        unsafe { System.dealloc(old, layout) }
    }
}

#[global_allocator]
static GLOBAL: Counting = Counting;

/// What frames took.
#[derive(Clone, Copy)]
struct Cost {
    /// All but [`OUTLIERS`] take at most this: allocations, bytes.
    most: (u64, u64),
    /// The worst.
    worst: (u64, u64),
    /// Mean of all frames.
    mean: (f64, f64),
}

/// Runs frames that take `time` and counts, what other threads do between them too.
fn frames(game: &mut Game, time: Duration, mut each: impl FnMut(&mut Game, usize)) -> Cost {
    let counts = || (ALLOCATIONS.load(Ordering::Relaxed), BYTES.load(Ordering::Relaxed));
    let (mut allocations, mut bytes) = (Vec::new(), Vec::new());
    let first = counts();
    let mut before = first;
    for frame in 0..FRAMES {
        let start = Instant::now();
        each(game, frame);
        game.app.update();
        std::thread::sleep(time.saturating_sub(start.elapsed()));
        let now = counts();
        allocations.push(now.0 - before.0);
        bytes.push(now.1 - before.1);
        before = now;
    }
    let mean = |from: u64, to: u64| (to - from) as f64 / FRAMES as f64;
    allocations.sort_unstable();
    bytes.sort_unstable();
    let at = |rank: usize| (allocations[rank], bytes[rank]);
    Cost {
        most: at(FRAMES - 1 - OUTLIERS),
        worst: at(FRAMES - 1),
        mean: (mean(first.0, before.0), mean(first.1, before.1)),
    }
}

/// The server's process, until its standard input ends.
#[test]
fn server_process() {
    let Some(invite) = std::env::var_os(INVITE) else { return };
    let folder = std::path::Path::new(&invite).with_extension("state");
    let authority = Arc::new(Authority::open(&folder).unwrap());
    let config = ListenConfig::new((Ipv4Addr::LOCALHOST, 0).into(), authority.clone());
    let listener = QuicListener::bind(config).unwrap();
    let invitation = Invitation {
        host: "127.0.0.1".into(),
        port: listener.local_addr().port(),
        token: authority.token(),
        authority: authority.fingerprint(),
    };
    let server =
        Server::start(ServerSettings::default(), Box::new(listener), authority.token()).unwrap();
    std::fs::write(&invite, invitation.to_string()).unwrap();
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
    server.stop();
}

/// Ends the server's process.
struct Serving(Child);

impl Drop for Serving {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A backend that says all is well and does nothing: what the game takes without light.
struct Quiet;

impl LightingBackend for Quiet {
    fn submit(&mut self, _: SnapshotId, _: Vec<SessionChange>) {}

    fn poll(&mut self) -> Option<GiUpdate> {
        None
    }

    fn state(&self) -> BackendState {
        BackendState::Converged
    }
}

fn orbit(game: &mut Game, frame: usize) {
    let (sin, cos) = (frame as f32 * 0.05).sin_cos();
    game.move_lamp(Vec3::new(2.0 + sin, 1.5, 2.0 + cos));
}

#[test]
fn a_client_takes_little_memory_a_frame() {
    let without = |mut game: Game| {
        frames(&mut game, Duration::ZERO, |_, _| {});
        let still = frames(&mut game, Duration::ZERO, |_, _| {});
        [still, frames(&mut game, Duration::ZERO, orbit)]
    };
    let bare = without(Game::bare());
    let quiet = without(Game::new(GiPlugin::with_backend(|_| Box::new(Quiet))));

    let folder = std::env::temp_dir().join(format!("farlight-allocations-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let invite = folder.join("invite");
    let serving = Command::new(std::env::current_exe().unwrap())
        .args(["server_process", "--exact", "--nocapture"])
        .env(INVITE, &invite)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn();
    let serving = Serving(serving.unwrap());
    let settings = RemoteSettings::from_invite_file(&invite);
    let mut game = Game::new(GiPlugin::with_backend(RemoteBackend::factory(settings)));
    game.settle();
    for _ in 0..WARM_UP {
        game.app.update();
        std::thread::sleep(FRAME / 2);
    }
    let updates = game.status().updates;
    let still = frames(&mut game, FRAME, |_, _| {});
    assert_eq!(game.status().updates, updates, "the scene is still");
    let moving = frames(&mut game, FRAME, orbit);
    assert!(game.status().updates > updates, "the light moves");
    for (what, cost) in [
        ("without the plugin, still", bare[0]),
        ("without the plugin, moving", bare[1]),
        ("with a backend that does nothing, still", quiet[0]),
        ("with a backend that does nothing, moving", quiet[1]),
        ("with a server, still", still),
        ("with a server, moving", moving),
    ] {
        let Cost { most, worst, mean } = cost;
        println!("{what}: {mean:?} on average, {most:?} in most frames, {worst:?} in the worst");
    }
    let more = |cost: &Cost, than: &Cost| {
        let (allocations, bytes) = than.mean;
        (cost.most.0.saturating_sub(allocations as u64), cost.most.1.saturating_sub(bytes as u64))
    };
    let within = |cost: (u64, u64), budget: (u64, u64)| cost.0 <= budget.0 && cost.1 <= budget.1;
    let (still_more, moving_more) = (more(&still, &bare[0]), more(&moving, &bare[1]));
    assert!(within(still_more, STILL), "a still frame takes {still_more:?} more");
    assert!(within(moving_more, MOVING), "a frame with moving light takes {moving_more:?} more");
    let mean = (moving.mean.0 - bare[1].mean.0, moving.mean.1 - bare[1].mean.1);
    assert!(mean.0 <= MOVING_MEAN.0 && mean.1 <= MOVING_MEAN.1, "{mean:?} more on average");
    drop(game);
    drop(serving);
    let _ = std::fs::remove_dir_all(&folder);
}
