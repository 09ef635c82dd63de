//! How long a frame takes when a measured material fills the screen, beside `StandardMaterial` in
//! the same run. Without a window; `cargo xtask bench btf --frames` runs it.
//!
//! All subjects take turns, frame by frame, so that whatever else the machine does meets each of
//! them alike. A frame lasts until the device has drawn it.

#[path = "../common/frame_time.rs"]
#[expect(dead_code, unreachable_pub, reason = "what the examples share")]
mod frame_time;
#[path = "../common/headless.rs"]
#[expect(dead_code, unreachable_pub, reason = "what the examples and tests share")]
mod headless;
mod options;
mod scene;

use std::{process::ExitCode, time::Duration};

use farlight::btf::BtfPlugin;
use frame_time::{FrameOptions, frame};
use headless::Headless;
use options::Options;
use scene::{LIGHTS, Subject};
use serde::Serialize;

/// Frames after a change that do not count.
const SETTLE: usize = 2;

#[derive(Serialize)]
struct Report {
    adapter: String,
    material: String,
    width: u32,
    height: u32,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    lights: usize,
    subject: Subject,
    /// Median, or the shortest with `--fastest`.
    frame_ms: f64,
    /// Over the frame of `StandardMaterial`.
    ratio: f64,
    /// The same without what an empty frame takes.
    ratio_of_the_object: f64,
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
    let btf = scene::material(options)?;
    let material = btf.info().name.clone();
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let mut headless = Headless::new(options.size, &assets, |app| {
        app.add_plugins(BtfPlugin);
        scene::build(app, btf);
    })?;
    let adapter = headless.adapter();
    println!("{}x{} pixels of {material} on {adapter}", options.size.x, options.size.y);
    // The data comes from threads, in the frames after it is first shown.
    for subject in [Subject::Standard, Subject::Nearest, Subject::Bilinear] {
        scene::show(headless.app.world_mut(), subject, 1);
        headless.capture_still()?;
    }
    if let Some(folder) = &options.frames.out {
        for lights in LIGHTS {
            for subject in Subject::ALL {
                scene::show(headless.app.world_mut(), subject, lights);
                if subject == Subject::Nothing {
                    continue;
                }
                let name = format!("{}-{lights}.png", subject.name().replace(' ', "-"));
                headless.capture_still()?.save(folder.join(name))?;
            }
        }
    }

    // One list of times for each number of lights and subject.
    let mut times = vec![Vec::new(); LIGHTS.len() * Subject::ALL.len()];
    for round in 0..=options.frames.rounds {
        for (at, times) in times.iter_mut().enumerate() {
            let lights = LIGHTS[at / Subject::ALL.len()];
            scene::show(headless.app.world_mut(), Subject::ALL[at % Subject::ALL.len()], lights);
            for _ in 0..SETTLE {
                frame(&mut headless)?;
            }
            let time = frame(&mut headless)?.wall;
            // In the first round drivers compile.
            if round > 0 {
                times.push(time);
            }
        }
    }
    let report = Report {
        adapter,
        material,
        width: options.size.x,
        height: options.size.y,
        rows: rows(times, &options.frames),
    };
    print(&report);
    options.frames.write(&report)
}

fn rows(times: Vec<Vec<Duration>>, options: &FrameOptions) -> Vec<Row> {
    let times: Vec<f64> = times.into_iter().map(|times| options.counts(times)).collect();
    let mut rows = Vec::new();
    for (lights, times) in LIGHTS.into_iter().zip(times.chunks(Subject::ALL.len())) {
        let [nothing, standard] = [times[0], times[1]];
        for (subject, time) in Subject::ALL.into_iter().zip(times) {
            rows.push(Row {
                lights,
                subject,
                frame_ms: *time,
                ratio: time / standard,
                ratio_of_the_object: (time - nothing) / (standard - nothing),
            });
        }
    }
    rows
}

fn print(report: &Report) {
    println!(
        "{:<8}{:<22}{:>12}{:>12}{:>18}",
        "lights", "subject", "frame", "ratio", "without empty"
    );
    for Row { lights, subject, frame_ms, ratio, ratio_of_the_object } in &report.rows {
        let name = subject.name();
        println!("{lights:<8}{name:<22}{frame_ms:>9.2} ms{ratio:>12.2}{ratio_of_the_object:>18.2}");
    }
}
