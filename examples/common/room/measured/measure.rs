//! What is measured while the app runs live; references come later, when nothing is timed any more.

use std::time::{Duration, Instant};

use farlight_gi_solver::{Scene, session::SnapshotId};

use super::{
    live::{Live, Moment, Write},
    network::{Traffic, Watch},
};

/// How long the first update may take after the lamp has begun to move.
const PATIENCE: Duration = Duration::from_secs(30);

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Rounds of moving and stopping.
    pub rounds: u32,
    /// Instants compared while moving, a round.
    pub instants: u32,
    /// Time between these.
    pub between: Duration,
    /// Time between stopping and comparing.
    pub after_stop: Duration,
    /// Doublings of the lamp's intensity.
    pub steps: u32,
    /// Time for the lighting to come to rest before each.
    pub settle: Duration,
    /// Time for which the step is watched.
    pub watch: Duration,
}

impl Plan {
    /// Everything.
    const FULL: Self = Self {
        rounds: 3,
        instants: 5,
        between: Duration::from_millis(600),
        after_stop: Duration::from_secs(2),
        steps: 7,
        settle: Duration::from_millis(2000),
        watch: Duration::from_millis(1200),
    };

    /// Time that the plan takes.
    pub fn time(&self) -> Duration {
        (self.between * self.instants + self.after_stop) * self.rounds
            + (self.settle + self.watch) * self.steps
    }

    /// A plan of about so many frames: fewer rounds and steps first, then shorter ones.
    pub fn new(frames: Option<u32>, pace: Duration) -> Self {
        let Some(frames) = frames else { return Self::FULL };
        let asked = pace * frames;
        let share = asked.as_secs_f32() / Self::FULL.time().as_secs_f32();
        let some = |n: u32| ((n as f32 * share).round() as u32).clamp(1, n);
        let few =
            Self { rounds: some(Self::FULL.rounds), steps: some(Self::FULL.steps), ..Self::FULL };
        let shorter = (asked.as_secs_f32() / few.time().as_secs_f32()).min(1.0);
        let time = |t: Duration| t.mul_f32(shorter).max(pace);
        Self {
            between: time(few.between),
            after_stop: time(few.after_stop),
            settle: time(few.settle),
            watch: time(few.watch),
            ..few
        }
    }
}

/// A step of the lamp's intensity.
pub struct Step {
    /// The scene before, and what was shown.
    pub before: Moment,
    /// The scene afterwards.
    pub after: Scene,
    /// When the light changed.
    pub at: Instant,
    /// The first snapshot that knows.
    pub snapshot: SnapshotId,
    /// What was written since.
    pub writes: Vec<Write>,
}

/// Everything that was seen.
#[derive(Default)]
pub struct Seen {
    /// While the lamp moved.
    pub moving: Vec<Moment>,
    /// Some time after it stopped.
    pub stopped: Vec<Moment>,
    /// Steps.
    pub steps: Vec<Step>,
    /// Updates while the lamp moved.
    pub updates: usize,
    /// Time for which it moved.
    pub moving_time: Duration,
    /// What went over the network in that time.
    pub traffic: Traffic,
}

/// Runs the plan.
pub fn measure(live: &mut Live, plan: &Plan) -> Result<Seen, String> {
    let mut seen = Seen::default();
    for round in 0..plan.rounds {
        eprintln!("moving, round {} of {}", round + 1, plan.rounds);
        live.lamp(|mut lamp| lamp.paused = false);
        live.frame()?;
        live.writes.clear();
        live.collect(false);
        let watch = Watch::start(live);
        let start = Instant::now();
        for _ in 0..plan.instants {
            live.run(plan.between)?;
            live.remember();
        }
        // Only on a machine that is much too busy, or if the light has stopped.
        while live.writes.is_empty() || !watch.has_light(live) {
            live.frame()?;
            if start.elapsed() > PATIENCE {
                return Err(format!("no update of the light arrived within {PATIENCE:?}"));
            }
        }
        seen.moving_time += start.elapsed();
        seen.updates += live.writes.len();
        watch.end(live, &mut seen.traffic);
        live.collect(true);
        live.lamp(|mut lamp| lamp.paused = true);
        let stopped = Instant::now();
        live.flush()?;
        seen.moving.append(&mut live.instants);
        live.run(plan.after_stop.saturating_sub(stopped.elapsed()))?;
        live.remember();
        live.flush()?;
        seen.stopped.append(&mut live.instants);
    }
    for step in 0..plan.steps {
        eprintln!("step {} of {}", step + 1, plan.steps);
        live.lamp(|mut lamp| lamp.distance += lamp.path.length() / plan.steps as f32);
        live.run(plan.settle)?;
        live.remember();
        live.flush()?;
        let before = live.instants.pop().ok_or("the instant before a step was lost")?;
        live.keep_texels = true;
        live.writes.clear();
        let at = Instant::now();
        live.scale_lamp(2.0);
        live.frame()?;
        let snapshot = live.log.lock().submitted;
        live.run(plan.watch)?;
        live.flush()?;
        let after = live.log.lock().scene.clone();
        let writes = std::mem::take(&mut live.writes);
        live.keep_texels = false;
        live.scale_lamp(0.5);
        seen.steps.push(Step { before, after, at, snapshot, writes });
    }
    live.collect(false);
    Ok(seen)
}
