//! What the controls take of a frame: on a quiet desk, with a gamepad, while gamepads come and go, and
//! with devices that hang. Without a window; `cargo xtask bench controls` runs it.
//!
//! Every subject is an app of its own; they take turns, frame by frame, so that whatever else the machine
//! does meets each of them alike. What counts is the CPU time of the thread that runs our systems (wall
//! time where the system doesn't say), and beside it the wall time: who waits for a device shows there.

use std::{
    io::Write as _,
    process::ExitCode,
    time::{Duration, Instant},
};

use bevy::{ecs::schedule::SingleThreadedExecutor, input::InputPlugin, prelude::*};
use farlight::{
    controls::{
        ControlsPlugin, ControlsSystems, GamepadThreadPlugin, UserFile,
        bevy_enhanced_input::prelude::EnhancedInputSystems,
        gamepads::{PadEvent, PadSource},
    },
    core::thread_cpu_time,
};
use serde::Serialize;

const HELP: &str = "\
What the controls take of a frame, whatever devices do.

USAGE
    controls_frame_time [--rounds N] [--json FILE]

OPTIONS
    --rounds N   frames of each subject, 100 to 1000000 (default 4000)
    --json FILE  write the figures
";

/// Frames before those that count.
const SETTLE: usize = 200;
/// Between frames, so that devices have the time to say something.
const PAUSE: Duration = Duration::from_micros(500);

/// What gamepads do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Subject {
    /// Nobody reads them.
    Quiet,
    /// One lies there.
    Idle,
    /// One is moved all the time.
    Moving,
    /// Four come and go, fifty times a second.
    ComeAndGo,
    /// They take a second to start, and hang for a tenth of one at each event.
    Slow,
}

const SUBJECTS: [Subject; 5] =
    [Subject::Quiet, Subject::Idle, Subject::Moving, Subject::ComeAndGo, Subject::Slow];

/// A source that does what a subject says.
struct Source {
    subject: Subject,
    said: u64,
}

impl PadSource for Source {
    fn next(&mut self) -> Option<PadEvent> {
        let Self { subject, said } = self;
        *said += 1;
        let connect = |pad: u64| PadEvent::Connected {
            pad: pad as usize,
            name: format!("pad {pad}"),
            vendor: None,
            product: None,
        };
        if *said == 1 {
            return Some(connect(0));
        }
        let turn = (*said as f32 * 0.1).sin();
        let moved = PadEvent::Axis { pad: 0, axis: GamepadAxis::LeftStickX, value: turn };
        match subject {
            Subject::Quiet | Subject::Idle => {
                std::thread::sleep(Duration::from_millis(20));
                None
            }
            Subject::Moving => {
                std::thread::sleep(Duration::from_millis(4));
                Some(moved)
            }
            Subject::ComeAndGo => {
                std::thread::sleep(Duration::from_millis(20));
                let pad = *said / 2 % 4;
                let gone = PadEvent::Disconnected { pad: pad as usize };
                Some(if *said % 2 == 0 { connect(pad) } else { gone })
            }
            Subject::Slow => {
                std::thread::sleep(Duration::from_millis(100));
                Some(moved)
            }
        }
    }
}

/// What our systems have taken in a frame.
#[derive(Resource, Default)]
struct Taken {
    began: Option<(Duration, Instant)>,
    cpu: Duration,
    wall: Duration,
}

fn now() -> (Duration, Instant) {
    let wall = Instant::now();
    (thread_cpu_time().unwrap_or_default(), wall)
}

fn begin(mut taken: ResMut<Taken>) {
    taken.began = Some(now());
}

fn end(mut taken: ResMut<Taken>) {
    let Some((cpu, wall)) = taken.began.take() else { return };
    let (cpu_now, wall_now) = now();
    taken.cpu += cpu_now.saturating_sub(cpu);
    taken.wall += wall_now.duration_since(wall);
}

fn app(subject: Subject) -> App {
    let mut app = App::new();
    let controls = ControlsPlugin { file: None, user_file: UserFile::Nowhere, gamepads: false };
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), InputPlugin, controls));
    if subject != Subject::Quiet {
        app.add_plugins(GamepadThreadPlugin::new(move || {
            if subject == Subject::Slow {
                std::thread::sleep(Duration::from_secs(1));
            }
            Ok(Box::new(Source { subject, said: 0 }))
        }));
    }
    // One after the other on one thread, so that what lies between two marks is ours.
    app.init_resource::<Taken>().edit_schedule(PreUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    app.add_systems(
        PreUpdate,
        (
            begin.before(ControlsSystems::Gamepads),
            end.after(ControlsSystems::Gamepads).before(bevy::input::InputSystems),
            begin.after(bevy::input::InputSystems).before(ControlsSystems::Sample),
            end.after(ControlsSystems::Sample).before(EnhancedInputSystems::Update),
            begin.after(EnhancedInputSystems::Apply).before(ControlsSystems::Announce),
            end.after(ControlsSystems::Announce),
        ),
    );
    app.finish();
    app.cleanup();
    app
}

#[derive(Serialize)]
struct Row {
    subject: Subject,
    cpu_p50_us: f64,
    cpu_p99_us: f64,
    /// Of the 99th percentile, over that of the quiet desk.
    cpu_p99_ratio: f64,
    wall_p50_us: f64,
    wall_p99_us: f64,
    wall_p99_ratio: f64,
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("controls_frame_time: {message}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), String> {
    let (mut rounds, mut json) = (4000, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{name} needs a value"));
        match name.as_str() {
            "-h" | "--help" => {
                print!("{HELP}");
                return Ok(());
            }
            "--rounds" => {
                let text = value()?;
                rounds = match text.parse() {
                    Ok(rounds @ 100..=1_000_000) => rounds,
                    _ => return Err(format!("--rounds: not '{text}'")),
                };
            }
            "--json" => json = Some(value()?),
            other => return Err(format!("{other} is not understood; --help lists all")),
        }
    }
    let mut apps: Vec<_> = SUBJECTS.into_iter().map(|subject| (subject, app(subject))).collect();
    let mut times = vec![(Vec::new(), Vec::new()); apps.len()];
    for round in 0..rounds + SETTLE {
        // Whoever comes first after the pause finds cold caches: everyone does in turn.
        for turn in 0..SUBJECTS.len() {
            let at = (turn + round) % SUBJECTS.len();
            let ((_, app), (cpu, wall)) = (&mut apps[at], &mut times[at]);
            *app.world_mut().resource_mut::<Taken>() = Taken::default();
            app.update();
            if round >= SETTLE {
                let taken = app.world().resource::<Taken>();
                cpu.push(taken.cpu);
                wall.push(taken.wall);
            }
        }
        std::thread::sleep(PAUSE);
    }
    let at = |times: &mut Vec<Duration>, percent: usize| {
        times.sort_unstable();
        times[(times.len() - 1) * percent / 100].as_secs_f64() * 1e6
    };
    let mut rows: Vec<Row> = Vec::new();
    println!("our systems, microseconds a frame   cpu p50    p99  ratio   wall p50    p99  ratio");
    for ((subject, _), (cpu, wall)) in apps.iter().zip(&mut times) {
        let (cpu_p99, wall_p99) = (at(cpu, 99), at(wall, 99));
        let quiet = rows.first().map_or((cpu_p99, wall_p99), |q| (q.cpu_p99_us, q.wall_p99_us));
        let row = Row {
            subject: *subject,
            cpu_p50_us: at(cpu, 50),
            cpu_p99_us: cpu_p99,
            cpu_p99_ratio: cpu_p99 / quiet.0,
            wall_p50_us: at(wall, 50),
            wall_p99_us: wall_p99,
            wall_p99_ratio: wall_p99 / quiet.1,
        };
        println!(
            "{:<33} {:>10.1} {:>6.1} {:>6.2} {:>10.1} {:>6.1} {:>6.2}",
            format!("{subject:?}"),
            row.cpu_p50_us,
            row.cpu_p99_us,
            row.cpu_p99_ratio,
            row.wall_p50_us,
            row.wall_p99_us,
            row.wall_p99_ratio
        );
        rows.push(row);
    }
    if let Some(file) = json {
        let text = serde_json::to_string_pretty(&rows).map_err(|error| error.to_string())?;
        let write = std::fs::File::create(&file).and_then(|mut f| f.write_all(text.as_bytes()));
        write.map_err(|error| format!("{file}: {error}"))?;
    }
    Ok(())
}
