//! Programs under observation for minutes: does the memory of a process grow?

pub(crate) mod demo;
pub(crate) mod server;

use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use crate::{Failure, process};

/// Growth of the resident memory that counts as noise of allocator and driver, in bytes.
const TOLERANCE: f64 = 8.0 * 1024.0 * 1024.0;

/// A child that does not outlive us when something fails.
pub(crate) struct Running(Child);

impl Running {
    pub(crate) fn id(&self) -> u32 {
        self.0.id()
    }

    /// How it ended, if it has.
    pub(crate) fn has_ended(&mut self) -> Result<Option<ExitStatus>, Failure> {
        self.0.try_wait().map_err(|error| format!("a process can't be watched: {error}."))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // Both fail where it has ended already, which is fine.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts a program; `name` is for errors.
pub(crate) fn spawn(command: &mut Command, name: &str) -> Result<Running, Failure> {
    command.spawn().map(Running).map_err(|error| format!("{name}: {error}."))
}

/// How the memory of a process went.
pub(crate) struct Watched {
    samples: Vec<Sample>,
    time: Duration,
}

/// Waits until a program ends, which must be without an error, and looks at the resident memory of the
/// process `id` meanwhile.
pub(crate) fn watch(program: &mut Running, name: &str, id: u32) -> Result<Watched, Failure> {
    let start = Instant::now();
    let mut samples = Vec::new();
    let mut announced = 0;
    loop {
        if let Some(status) = program.has_ended()? {
            if !status.success() {
                return Err(format!("{name} failed ({status})."));
            }
            return Ok(Watched { samples, time: start.elapsed() });
        }
        let at = start.elapsed().as_secs_f64();
        if let Some(bytes) = resident_bytes(id) {
            samples.push(Sample { at, bytes: bytes as f64 });
            if at as u64 / 60 >= announced {
                println!("  {:5.0} s  {:7.1} MiB resident", at, mebibytes(bytes as f64));
                process::flush();
                announced += 1;
            }
        }
        std::thread::sleep(Duration::from_millis(500));
    }
}

impl Watched {
    /// Says how the memory went, and fails if it grows.
    pub(crate) fn judge(&self, name: &str) -> Result<(), Failure> {
        if !cfg!(target_os = "linux") {
            println!("SKIPPED: memory of {name}: it is read from /proc, which this system lacks.");
            return Ok(());
        }
        let growth = growth(&self.samples)
            .ok_or_else(|| format!("{name} ended after {:.0?}.", self.time))?;
        println!(
            "Resident memory of {name}: median {:.1} MiB in the second fifth of the time, {:.1} MiB \
             in the last, growth {:+.2} MiB (tolerance {:.0} MiB).",
            mebibytes(growth.early),
            mebibytes(growth.late),
            mebibytes(growth.late - growth.early),
            mebibytes(TOLERANCE),
        );
        if growth.late - growth.early > TOLERANCE {
            return Err(format!("the memory of {name} grows."));
        }
        Ok(())
    }
}

/// Resident memory at a time after the start.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Seconds.
    at: f64,
    bytes: f64,
}

/// Medians of the resident memory, in bytes.
#[derive(Debug, PartialEq)]
struct Growth {
    early: f64,
    late: f64,
}

/// Compares the second fifth of the time with the last; the first fifth is loading and warming up.
/// Medians, since a screenshot or a bake makes short peaks.
fn growth(samples: &[Sample]) -> Option<Growth> {
    let end = samples.last()?.at;
    let median = |from: f64, to: f64| {
        let mut bytes: Vec<f64> = samples
            .iter()
            .filter(|sample| (from * end..=to * end).contains(&sample.at))
            .map(|sample| sample.bytes)
            .collect();
        bytes.sort_by(f64::total_cmp);
        bytes.get(bytes.len() / 2).copied()
    };
    Some(Growth { early: median(0.2, 0.4)?, late: median(0.8, 1.0)? })
}

/// Resident memory of a process; nothing where there is no `/proc`.
fn resident_bytes(id: u32) -> Option<u64> {
    parse_resident(&std::fs::read_to_string(format!("/proc/{id}/status")).ok()?)
}

/// `VmRSS` of `/proc/ID/status`, which is in KiB (proc(5)).
fn parse_resident(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}

fn mebibytes(bytes: f64) -> f64 {
    bytes / (1024.0 * 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(bytes: impl Fn(f64) -> f64) -> Vec<Sample> {
        (0..=100).map(f64::from).map(|at| Sample { at, bytes: bytes(at) }).collect()
    }

    #[test]
    fn warming_up_and_peaks_are_no_growth() {
        let warm = |at: f64| if at < 15.0 { at } else { 15.0 };
        let peaks = |at: f64| if at % 10.0 == 0.0 { 1000.0 } else { warm(at) };
        assert_eq!(growth(&samples(peaks)), Some(Growth { early: 15.0, late: 15.0 }));
    }

    #[test]
    fn a_leak_is_growth() {
        let growth = growth(&samples(|at| 100.0 + at)).unwrap();
        assert!((growth.late - growth.early - 60.0).abs() <= 1.0, "{growth:?}");
    }

    #[test]
    fn too_short_is_no_answer() {
        assert_eq!(growth(&[]), None);
        assert_eq!(growth(&[Sample { at: 0.5, bytes: 1.0 }]), None);
    }

    #[test]
    fn resident_memory_is_read_from_the_status() {
        assert_eq!(parse_resident("Name:\tx\nVmRSS:\t    1234 kB\nThreads:\t3\n"), Some(1_263_616));
        assert_eq!(parse_resident("Name:\tx\n"), None);
    }
}
