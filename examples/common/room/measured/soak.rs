//! Memory over a long run: a counting allocator, and resident memory from the system.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

use farlight::gi::BackendFactory;
use serde::Serialize;

use super::{args::Args, run};

/// The system's allocator, counted.
pub struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);
static ALLOCATED: AtomicU64 = AtomicU64::new(0);
static FREED: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call is handed to the system's allocator unchanged; only counters are added.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: the caller keeps `alloc`'s contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: the caller keeps `alloc_zeroed`'s contract.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size, layout.size());
        // SAFETY: the caller keeps `realloc`'s contract.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        FREED.fetch_add(layout.size() as u64, Ordering::Relaxed);
        // SAFETY: the caller keeps `dealloc`'s contract.
        unsafe { System.dealloc(pointer, layout) }
    }
}

fn count(allocated: usize, freed: usize) {
    ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
    ALLOCATED.fetch_add(allocated as u64, Ordering::Relaxed);
    FREED.fetch_add(freed as u64, Ordering::Relaxed);
}

/// Memory at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// Pages in physical memory, in bytes; 0 where the system doesn't say.
    pub resident_bytes: u64,
    /// Bytes allocated on the Rust heap and not freed.
    pub live_bytes: u64,
    /// Allocations so far.
    pub allocations: u64,
}

impl Memory {
    /// Now.
    pub fn now() -> Self {
        let freed = FREED.load(Ordering::Relaxed);
        Self {
            resident_bytes: resident_bytes().unwrap_or(0),
            live_bytes: ALLOCATED.load(Ordering::Relaxed).saturating_sub(freed),
            allocations: ALLOCATIONS.load(Ordering::Relaxed),
        }
    }
}

/// Second field of /proc/self/statm, in pages of 4 KiB.
fn resident_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(text.split_whitespace().nth(1)?.parse::<u64>().ok()? * 4096)
}

/// Lines that a soak prints at most, and the shortest time between two.
const LINES: u32 = 60;
const SHORTEST: Duration = Duration::from_secs(1);
/// The part of the run in which memory may still grow: caches fill, textures are made.
const WARM_UP: f64 = 0.2;
/// Growth of live memory after the warm-up that passes, as a fraction, and in bytes.
const GROWTH: f64 = 0.02;
const GROWTH_BYTES: f64 = 4e6;

/// One line.
#[derive(Clone, Copy, Debug, Serialize)]
struct Line {
    elapsed_s: f64,
    #[serde(flatten)]
    memory: Memory,
    frames: u64,
    updates: u64,
}

/// Runs with a moving lamp and ball and prints JSON lines; an error if memory grew.
pub fn soak(args: &Args, light: BackendFactory, time: Duration) -> Result<(), String> {
    let pace = Duration::from_millis(50);
    let mut live = run::start(args, light, pace)?;
    run::first_light(&mut live)?;
    let start = Instant::now();
    let every = (time / LINES).max(SHORTEST);
    let (mut frames, mut lines) = (0, Vec::<Line>::new());
    while start.elapsed() < time {
        live.frame()?;
        frames += 1;
        live.writes.clear();
        live.frame_ms.clear();
        if start.elapsed() >= every * (lines.len() as u32 + 1) {
            let line = Line {
                elapsed_s: start.elapsed().as_secs_f64(),
                memory: Memory::now(),
                frames,
                updates: live.status_mut().updates,
            };
            println!("{}", serde_json::to_string(&line).map_err(|e| e.to_string())?);
            lines.push(line);
        }
    }
    judge(&lines)
}

/// Compares the middle of what comes right after the warm-up with that of the end.
fn judge(lines: &[Line]) -> Result<(), String> {
    let warm = &lines[(lines.len() as f64 * WARM_UP).ceil() as usize..];
    let part = warm.len() / 4;
    let (Some(first), Some(last)) = (warm.first(), warm.last()) else {
        return Err("too short to judge: at least 5 s are needed".into());
    };
    if last.updates <= first.updates {
        return Err("no lighting update arrived after the warm-up".into());
    }
    let middle = |lines: &[Line], of: fn(&Line) -> u64| {
        let mut values: Vec<u64> = lines.iter().map(of).collect();
        values.sort_unstable();
        values.get(values.len() / 2).copied().unwrap_or(0) as f64
    };
    let grown = |of: fn(&Line) -> u64| {
        let (early, late) =
            (middle(&warm[..part.max(1)], of), middle(&warm[warm.len() - part.max(1)..], of));
        (early, late - early)
    };
    let (live, live_growth) = grown(|l| l.memory.live_bytes);
    let (resident, resident_growth) = grown(|l| l.memory.resident_bytes);
    let frames = (last.frames - first.frames).max(1) as f64;
    let allocations = (last.memory.allocations - first.memory.allocations) as f64;
    let verdict = serde_json::json!({
        "live_growth_bytes": live_growth,
        "resident_growth_bytes": resident_growth,
        "allocations_per_frame": allocations / frames,
        "seconds_after_warm_up": last.elapsed_s - first.elapsed_s,
    });
    println!("{verdict}");
    if live_growth > GROWTH_BYTES.max(GROWTH * live) {
        return Err(format!("live memory grew by {live_growth} bytes after the warm-up"));
    }
    if resident_growth > (4.0 * GROWTH_BYTES).max(2.0 * GROWTH * resident) {
        return Err(format!("resident memory grew by {resident_growth} bytes after the warm-up"));
    }
    Ok(())
}
