//! The demo under observation: does the memory of its process grow?
//!
//! The program counts its own allocations and reports them; here the process is looked at from
//! outside, so that what the allocator, the driver or a library keeps is seen too.

use std::io::{BufRead as _, BufReader};
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::{Failure, demo, process};

/// Growth of the resident memory that counts as noise of allocator and driver, in bytes.
const TOLERANCE: f64 = 8.0 * 1024.0 * 1024.0;

/// Runs the demo headless for `seconds` and fails if its memory grows. Its own output, the report
/// of its allocations included, is passed on.
pub(crate) fn run(seconds: f64, rest: &[String]) -> Result<(), Failure> {
    let program = demo::build()?;
    let mut command = demo::command(&program, true);
    command.args(["--soak", &format!("{seconds:.0}")]).args(rest).stdout(Stdio::piped());
    println!("$ {}", process::shown(&command));
    process::flush();
    let start = Instant::now();
    let mut child = command.spawn().map_err(|error| format!("the demo: {error}."))?;
    let output = child.stdout.take().map(|stream| {
        std::thread::spawn(move || {
            for line in BufReader::new(stream).lines().map_while(Result::ok) {
                println!("{line}");
            }
        })
    });
    let mut samples = Vec::new();
    let mut announced = 0;
    let status = loop {
        if let Some(status) = child.try_wait().map_err(|error| format!("the demo: {error}."))? {
            break status;
        }
        let at = start.elapsed().as_secs_f64();
        if let Some(bytes) = resident_bytes(child.id()) {
            samples.push(Sample { at, bytes: bytes as f64 });
            if at as u64 / 60 >= announced {
                println!("  {:5.0} s  {:7.1} MiB resident", at, mebibytes(bytes as f64));
                process::flush();
                announced += 1;
            }
        }
        std::thread::sleep(Duration::from_millis(500));
    };
    if let Some(output) = output {
        let _ = output.join();
    }
    if !status.success() {
        return Err(format!("the demo failed ({status})."));
    }
    if !cfg!(target_os = "linux") {
        println!("Resident memory is read from /proc, which this system lacks.");
        return Ok(());
    }
    let growth =
        growth(&samples).ok_or_else(|| format!("the demo ended after {:.0?}.", start.elapsed()))?;
    println!(
        "Resident memory: median {:.1} MiB in the second fifth of the time, {:.1} MiB in the last, \
         growth {:+.2} MiB (tolerance {:.0} MiB).",
        mebibytes(growth.early),
        mebibytes(growth.late),
        mebibytes(growth.late - growth.early),
        mebibytes(TOLERANCE),
    );
    if growth.late - growth.early > TOLERANCE {
        return Err("memory grows.".to_owned());
    }
    Ok(())
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
