//! How far a bake is, and how to stop it.

use std::{
    collections::VecDeque,
    fmt,
    ops::ControlFlow,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicU64, Ordering::Relaxed},
    },
    time::{Duration, Instant},
};

/// Hears what a bake does. It is called from any thread, one call at a time, at most ten times a second
/// for progress.
pub trait Observer: Send {
    /// Something happened.
    fn event(&mut self, event: Event<'_>);
}

/// What a bake tells.
#[derive(Clone, Debug, PartialEq)]
pub enum Event<'a> {
    /// Work goes on.
    Progress(Progress<'a>),
    /// Something was left out, repaired or is not as one may expect.
    Warning(&'a str),
    /// All is done for now; a bake that [watches](crate::watch) waits for changes.
    Idle,
}

/// How far a bake is.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress<'a> {
    /// What is done now.
    pub stage: Stage,
    /// For which scenario; empty if for all.
    pub scenario: &'a str,
    /// How much of the stage is done, 0 to 1.
    pub done: f32,
    /// Time until the whole bake ends; `None` until it can be told.
    pub left: Option<Duration>,
}

/// The parts of a bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Files into memory.
    Read,
    /// Second UV sets.
    Unwrap,
    /// Where texels lie, on pages and on surfaces.
    Layout,
    /// What arrives straight from lights whose direct light is baked.
    Direct,
    /// What surfaces exchange, coarsely: where gather rays end.
    Exchange,
    /// What surfaces reflect and emit, and the sky.
    Gather,
    /// Light in the air.
    Probes,
    /// Noise is filtered.
    Denoise,
    /// Files.
    Write,
}

impl Stage {
    /// All of them, in their order.
    pub const ALL: [Self; 9] = [
        Self::Read,
        Self::Unwrap,
        Self::Layout,
        Self::Direct,
        Self::Exchange,
        Self::Gather,
        Self::Probes,
        Self::Denoise,
        Self::Write,
    ];
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "reading",
            Self::Unwrap => "lightmap coordinates",
            Self::Layout => "texels",
            Self::Direct => "direct light",
            Self::Exchange => "light between surfaces",
            Self::Gather => "indirect light",
            Self::Probes => "probes",
            Self::Denoise => "filtering noise",
            Self::Write => "writing",
        })
    }
}

/// Hears nothing.
impl Observer for () {
    fn event(&mut self, _event: Event<'_>) {}
}

/// Work that is still to be done, with a guess of its seconds on two cores.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub(crate) stage: Stage,
    pub(crate) scenario: String,
    pub(crate) seconds: f64,
    /// Whether the guess is a measurement: of the same stage of another scenario.
    pub(crate) measured: bool,
}

impl Step {
    /// A step with a guess.
    pub(crate) fn new(stage: Stage, scenario: &str, seconds: f64) -> Self {
        Self { stage, scenario: scenario.to_owned(), seconds, measured: false }
    }
}

/// What all parts of a bake share: whom they tell, and whether they go on.
pub(crate) struct Work<'a> {
    observer: Mutex<&'a mut dyn Observer>,
    stop: Arc<AtomicBool>,
    /// Set once the inputs changed under the bake's hands.
    outdated: AtomicBool,
    is_outdated: &'a (dyn Fn() -> bool + Sync),
    pub(crate) start: Instant,
    steps: Mutex<VecDeque<Step>>,
    /// Seconds that finished steps took, and that were guessed: machines differ, and are busy.
    pace: Mutex<[f64; 2]>,
    warnings: Mutex<Vec<String>>,
    seconds: Mutex<Vec<(Stage, Duration)>>,
}

/// A stage that goes on.
pub(crate) struct Running<'a> {
    work: &'a Work<'a>,
    step: Step,
    total: u64,
    done: AtomicU64,
    skipped: AtomicBool,
    start: Instant,
    /// When it was last told, in milliseconds since `start`.
    told: AtomicU64,
    end: Option<Instant>,
}

/// Between two reports.
const EVERY: Duration = Duration::from_millis(100);

impl<'a> Work<'a> {
    pub(crate) fn new(
        observer: &'a mut dyn Observer,
        stop: Arc<AtomicBool>,
        is_outdated: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        Self {
            observer: Mutex::new(observer),
            stop,
            outdated: AtomicBool::new(false),
            is_outdated,
            start: Instant::now(),
            steps: Mutex::default(),
            pace: Mutex::new([1.0; 2]),
            warnings: Mutex::default(),
            seconds: Mutex::default(),
        }
    }

    /// Whether somebody wants it to stop.
    pub(crate) fn stopped(&self) -> bool {
        self.stop.load(Relaxed) || self.outdated.load(Relaxed)
    }

    /// Whether it stops because its inputs changed.
    pub(crate) fn outdated(&self) -> bool {
        self.outdated.load(Relaxed)
    }

    pub(crate) fn warn(&self, text: impl Into<String>) {
        let text = text.into();
        if let Ok(mut observer) = self.observer.lock() {
            observer.event(Event::Warning(&text));
        }
        lock(&self.warnings).push(text);
    }

    pub(crate) fn warnings(&self) -> Vec<String> {
        lock(&self.warnings).clone()
    }

    /// Seconds by stage, in their order.
    pub(crate) fn seconds(&self) -> Vec<(Stage, Duration)> {
        let seconds = lock(&self.seconds);
        let of = |stage| seconds.iter().filter(|(s, _)| *s == stage).map(|(_, time)| *time).sum();
        Stage::ALL.map(|stage| (stage, of(stage))).to_vec()
    }

    /// How many times as long as was guessed finished steps took.
    pub(crate) fn pace(&self) -> f64 {
        let [took, guessed] = *lock(&self.pace);
        (took / guessed).clamp(0.2, 50.0)
    }

    /// Says what will be done, so that the time that is left can be told.
    pub(crate) fn plan(&self, steps: impl IntoIterator<Item = Step>) {
        *lock(&self.steps) = steps.into_iter().collect();
    }

    /// Begins a stage of `total` units of work; 0 where nothing tells how far it is.
    pub(crate) fn begin(&'a self, stage: Stage, scenario: &str, total: u64) -> Running<'a> {
        let step = {
            let mut steps = lock(&self.steps);
            let found = steps.iter().position(|s| s.stage == stage && s.scenario == scenario);
            // What was planned before it was skipped.
            found.and_then(|at| steps.drain(..=at).next_back())
        };
        let step = step.unwrap_or_else(|| Step::new(stage, scenario, 0.0));
        let running = Running {
            work: self,
            step,
            total,
            done: AtomicU64::new(0),
            skipped: AtomicBool::new(false),
            start: Instant::now(),
            told: AtomicU64::new(0),
            end: None,
        };
        running.tell();
        running
    }
}

impl Running<'_> {
    /// So much is done already, from an earlier run.
    pub(crate) fn skip(&self, units: u64) {
        self.skipped.store(true, Relaxed);
        self.done.fetch_add(units, Relaxed);
    }

    /// It goes on until a certain time, whatever is done then.
    pub(crate) fn until(&mut self, end: Instant) {
        self.end = Some(end);
    }

    /// So much more is done. Breaks if the work is to stop.
    pub(crate) fn tick(&self, units: u64) -> ControlFlow<()> {
        self.done.fetch_add(units, Relaxed);
        let now = self.start.elapsed().as_millis() as u64;
        let told = self.told.load(Relaxed);
        if now >= told + EVERY.as_millis() as u64
            && self.told.compare_exchange(told, now, Relaxed, Relaxed).is_ok()
        {
            if (self.work.is_outdated)() {
                self.work.outdated.store(true, Relaxed);
            }
            self.tell();
        }
        if self.work.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn tell(&self) {
        let now = Instant::now();
        let elapsed = now.duration_since(self.start).as_secs_f64();
        let pace = self.work.pace();
        let guess = self.step.guess(pace);
        let done = match self.end {
            // It goes slower and slower towards the end of a guess that was too low.
            None if self.total == 0 => 1.0 - (-2.0 * elapsed / guess.max(0.1)).exp(),
            None => self.done.load(Relaxed) as f64 / self.total as f64,
            Some(end) => elapsed / end.duration_since(self.start).as_secs_f64().max(1e-3),
        };
        let done = done.clamp(0.0, 1.0);
        let later: f64 = lock(&self.work.steps).iter().map(|step| step.guess(pace)).sum();
        let known = done > 0.02 || (elapsed > guess && done > 1e-3);
        let this = match self.end {
            Some(end) => Some(end.saturating_duration_since(now).as_secs_f64()),
            None if known && elapsed > 1.0 && self.total > 0 => Some(elapsed * (1.0 - done) / done),
            // A guess: better than nothing where the stage is short.
            None => Some(guess * (1.0 - done)),
        };
        let left = this.map(|this| this + later).filter(|left| *left > 0.0);
        let event = Event::Progress(Progress {
            stage: self.step.stage,
            scenario: &self.step.scenario,
            done: done as f32,
            left: left.map(Duration::from_secs_f64),
        });
        // Whoever comes while somebody else tells has nothing to add.
        if let Ok(mut observer) = self.work.observer.try_lock() {
            observer.event(event);
        }
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        let time = self.start.elapsed();
        lock(&self.work.seconds).push((self.step.stage, time));
        // What was known before tells nothing.
        let complete = self.done.load(Relaxed) >= self.total && self.end.is_none();
        if !complete || self.step.seconds <= 0.0 || self.skipped.load(Relaxed) {
            return;
        }
        let took = time.as_secs_f64();
        if !self.step.measured {
            let [all, guessed] = &mut *lock(&self.work.pace);
            *all += took;
            *guessed += self.step.seconds;
        }
        // The same stage of other scenarios will take about as long.
        let ratio = took / self.step.seconds;
        for step in lock(&self.work.steps).iter_mut().filter(|s| s.stage == self.step.stage) {
            step.seconds *= ratio;
            step.measured = true;
        }
    }
}

impl Step {
    /// Seconds that it will take, where others took `pace` times as long as was guessed.
    fn guess(&self, pace: f64) -> f64 {
        if self.measured { self.seconds } else { self.seconds * pace }
    }
}

/// A panic in an observer must not become one of every thread.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
