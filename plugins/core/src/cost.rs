//! What our systems cost a frame, in CPU time of the threads they run on and in wall time.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

use bevy::{ecs::resource::Resource, platform::time::Instant};

/// CPU time that the calling thread has used; `None` where the system doesn't say.
#[must_use]
pub fn thread_cpu_time() -> Option<Duration> {
    #[cfg(unix)]
    return clock(libc::CLOCK_THREAD_CPUTIME_ID);
    #[cfg(not(unix))]
    None
}

/// CPU time that all threads of this process have used; `None` where the system doesn't say. Where
/// the CPU draws, this is what a frame costs, whatever else the machine does.
#[must_use]
pub fn process_cpu_time() -> Option<Duration> {
    #[cfg(unix)]
    return clock(libc::CLOCK_PROCESS_CPUTIME_ID);
    #[cfg(not(unix))]
    None
}

#[cfg(unix)]
fn clock(id: libc::clockid_t) -> Option<Duration> {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `time` is a valid timespec for the call to fill in; nothing else is touched.
    let result = unsafe { libc::clock_gettime(id, &raw mut time) };
    (result == 0).then(|| Duration::new(time.tv_sec as u64, time.tv_nsec as u32))
}

/// Adds up what systems cost, from whatever thread and world they run in; cloning shares the sums.
///
/// One meter has a few stages, numbered by its owner. A stage's time in one frame is the sum over
/// the systems that were measured for it.
#[derive(Resource, Clone, Debug)]
pub struct CostMeter {
    stages: Arc<[Sums]>,
}

#[derive(Debug, Default)]
struct Sums {
    cpu_ns: AtomicU64,
    wall_ns: AtomicU64,
}

/// What was used since the last [`CostMeter::take`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured {
    /// CPU time of the threads (wall time where the system doesn't know it).
    pub cpu: Duration,
    /// Wall time.
    pub wall: Duration,
}

/// Measures until it is dropped.
#[must_use = "it measures until it is dropped"]
pub struct CostGuard<'a> {
    sums: &'a Sums,
    cpu: Option<Duration>,
    wall: Instant,
}

impl CostMeter {
    /// A meter with `stages` stages.
    #[must_use]
    pub fn new(stages: usize) -> Self {
        Self { stages: (0..stages).map(|_| Sums::default()).collect() }
    }

    /// Measures the calling thread for `stage` until the guard is dropped, which must happen on
    /// the same thread. A stage that doesn't exist counts as the last.
    pub fn measure(&self, stage: usize) -> CostGuard<'_> {
        let sums = &self.stages[stage.min(self.stages.len() - 1)];
        CostGuard { sums, cpu: thread_cpu_time(), wall: Instant::now() }
    }

    /// What `stage` used since it was last asked, and starts again.
    #[must_use]
    pub fn take(&self, stage: usize) -> Measured {
        let Some(sums) = self.stages.get(stage) else { return Measured::default() };
        Measured {
            cpu: Duration::from_nanos(sums.cpu_ns.swap(0, Ordering::Relaxed)),
            wall: Duration::from_nanos(sums.wall_ns.swap(0, Ordering::Relaxed)),
        }
    }
}

impl Drop for CostGuard<'_> {
    fn drop(&mut self) {
        let wall = self.wall.elapsed();
        let cpu = match (self.cpu, thread_cpu_time()) {
            (Some(start), Some(end)) => end.saturating_sub(start),
            _ => wall,
        };
        self.sums.cpu_ns.fetch_add(cpu.as_nanos() as u64, Ordering::Relaxed);
        self.sums.wall_ns.fetch_add(wall.as_nanos() as u64, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleeping_is_wall_time_but_not_cpu_time() {
        let meter = CostMeter::new(1);
        {
            let _guard = meter.measure(0);
            std::thread::sleep(Duration::from_millis(20));
        }
        let measured = meter.take(0);
        assert!(measured.wall >= Duration::from_millis(20));
        if thread_cpu_time().is_some() {
            assert!(measured.cpu < measured.wall / 2, "{measured:?}");
        }
        assert_eq!(meter.take(0), Measured::default());
    }
}
