//! How long a frame takes while the environment's light refines, beside the same lights as plain
//! ones, and while a refined picture rests. Without a window; `cargo xtask bench ibl` runs it.
//!
//! Every subject is an app of its own with the same scene; they take turns, frame by frame, so that
//! whatever else the machine does meets each of them alike. A frame lasts until the device has drawn
//! it.

#[path = "../common/frame_time.rs"]
#[expect(unreachable_pub, reason = "what the examples share")]
mod frame_time;
#[path = "../common/headless.rs"]
#[expect(dead_code, unreachable_pub, reason = "what the examples and tests share")]
mod headless;
mod options;
mod scene;

use std::{process::ExitCode, time::Duration};

use bevy::{diagnostic::DiagnosticsStore, prelude::*};
use frame_time::{FrameTime, frame};
use headless::Headless;
use options::Options;
use scene::Subject;
use serde::Serialize;

/// Frames before those that count: files are read, pipelines compiled, lights chosen.
const SETTLE: usize = 12;
/// Frames after which a picture must be refined.
const PATIENCE: usize = 200;

#[derive(Serialize)]
struct Report {
    adapter: String,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    width: u32,
    height: u32,
    subject: Subject,
    /// Median, or the shortest with `--fastest`.
    frame_ms: f64,
    /// Over the frame of what it is compared with.
    ratio: f64,
    /// CPU time of all threads, where the system says so, and its ratio: the measure to trust where
    /// the CPU draws and the machine is busy.
    cpu_ms: f64,
    cpu_ratio: f64,
    /// What the device took for our pass, where it can say so.
    pass_ms: Option<f64>,
}

fn main() -> ExitCode {
    match Options::from_args().and_then(|options| run(&options)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), String> {
    let mut report = Report { adapter: String::new(), rows: Vec::new() };
    for size in &options.sizes {
        measure(options, *size, &mut report)?;
    }
    options.frames.write(&report)
}

fn measure(options: &Options, size: UVec2, report: &mut Report) -> Result<(), String> {
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let mut apps = Vec::new();
    for subject in Subject::ALL {
        let mut app = Headless::new(size, &assets, |app| scene::build(app, subject))?;
        app.set_frame_time(Duration::from_millis(16));
        for _ in 0..SETTLE {
            app.update()?;
        }
        let mut left = PATIENCE;
        while let Err(problem) = scene::check(app.app.world_mut(), subject) {
            left = left.checked_sub(1).ok_or(problem)?;
            app.update()?;
        }
        apps.push((subject, app, Vec::new()));
    }
    report.adapter = apps[0].1.adapter();
    println!("{}x{} pixels on {}", size.x, size.y, report.adapter);
    for round in 0..=options.frames.rounds {
        for (_, app, times) in &mut apps {
            let time = frame(app)?;
            if round > 0 {
                times.push(time);
            }
        }
    }
    for (subject, app, _) in &mut apps {
        scene::check(app.app.world_mut(), *subject)?;
        if let Some(folder) = &options.frames.out {
            let name = format!("{}-{}.png", subject.name().replace(' ', "-"), size.x);
            app.capture()?.save(folder.join(name))?;
        }
    }
    let mut medians = Vec::new();
    for (subject, _, times) in &apps {
        let counts = |time: fn(&FrameTime) -> Duration| {
            options.frames.counts(times.iter().map(time).collect())
        };
        medians.push((*subject, counts(|t| t.wall), counts(|t| t.cpu)));
    }
    println!(
        "{:<40}{:>12}{:>8}{:>12}{:>8}{:>12}",
        "subject / beside", "frame", "ratio", "CPU", "ratio", "our pass"
    );
    for (subject, app, _) in &apps {
        let of = |wanted: Subject| {
            medians.iter().find(|m| m.0 == wanted).map_or((0.0, 0.0), |m| (m.1, m.2))
        };
        let ((frame_ms, cpu_ms), beside) = (of(*subject), of(subject.beside()));
        let (ratio, cpu_ratio) = (frame_ms / beside.0, cpu_ms / beside.1);
        let pass_ms = pass(app);
        let told = pass_ms.map_or("".to_owned(), |ms| format!("{ms:.2} ms"));
        let name = format!("{} / {}", subject.name(), subject.beside().name());
        println!(
            "{name:<40}{frame_ms:>9.2} ms{ratio:>8.3}{cpu_ms:>9.2} ms{cpu_ratio:>8.3}{told:>12}"
        );
        let (width, height, subject) = (size.x, size.y, *subject);
        let row = Row { width, height, subject, frame_ms, ratio, cpu_ms, cpu_ratio, pass_ms };
        report.rows.push(row);
    }
    Ok(())
}

/// The device's own time of our pass.
fn pass(headless: &Headless) -> Option<f64> {
    let store = headless.app.world().get_resource::<DiagnosticsStore>()?;
    store
        .iter()
        .find(|diagnostic| {
            let path = diagnostic.path().as_str();
            path.contains("farlight_ibl") && path.ends_with("elapsed_gpu")
        })
        .and_then(|diagnostic| diagnostic.smoothed())
}
