//! What actions said, recorded and said again.
//!
//! A replay takes the place of the devices: while it runs, actions say what the recording says, through
//! `bevy_enhanced_input`'s own mocks, so that whoever reads actions notices nothing.

use bevy::{prelude::*, time::Real};
use bevy_enhanced_input::prelude::*;
use farlight_bindings::{ActionInfo, RecordedEvent, Recording, RecordingError};

use crate::{
    read::{ActionEntities, ActionEntity},
    sample::value,
};

/// Records what actions say, from [`start`](Self::start) to [`stop`](Self::stop).
#[derive(Resource, Default)]
pub struct ActionRecorder {
    running: Option<Running>,
    stopped: Option<Recording>,
    problem: Option<String>,
}

struct Running {
    recording: Recording,
    /// What each action said last: held, value.
    last: Vec<(bool, [f32; 2])>,
    frame: u64,
    seconds: f64,
}

impl ActionRecorder {
    /// Begins a recording with the next frame; one that runs is thrown away.
    pub fn start(&mut self) {
        let (recording, last) = (Recording::default(), Vec::new());
        self.running = Some(Running { recording, last, frame: 0, seconds: 0.0 });
        self.problem = None;
    }

    /// Ends the recording and hands it out; `None` if there is none.
    pub fn stop(&mut self) -> Option<Recording> {
        self.running.take().map(|running| running.recording).or_else(|| self.stopped.take())
    }

    /// Whether it records.
    pub fn is_recording(&self) -> bool {
        self.running.is_some()
    }

    /// Why it stopped by itself: it was full.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }
}

/// Records a frame.
pub(crate) fn record(
    mut recorder: ResMut<ActionRecorder>,
    entities: Res<ActionEntities>,
    actions: Query<(&ActionValue, &TriggerState)>,
    time: Res<Time<Real>>,
) {
    let Some(running) = &mut recorder.bypass_change_detection().running else { return };
    let recorded = running.frame(&entities.all, &actions, time.delta_secs_f64());
    if let Err(error) = recorded {
        warn!("recording ends: {error}");
        recorder.problem = Some(error.to_string());
        recorder.stopped = recorder.running.take().map(|running| running.recording);
    }
}

impl Running {
    fn frame(
        &mut self,
        all: &[ActionEntity],
        actions: &Query<(&ActionValue, &TriggerState)>,
        seconds: f64,
    ) -> Result<(), RecordingError> {
        if self.last.is_empty() {
            self.recording = Recording::new(all.iter().map(|action| action.info.name))?;
            self.last = vec![(false, [0.0; 2]); all.len()];
        } else {
            self.frame += 1;
            self.seconds += seconds;
        }
        let (frame, seconds) = (self.frame, self.seconds);
        for (at, (action, last)) in all.iter().zip(&mut self.last).enumerate() {
            let Ok((value, state)) = actions.get(action.entity) else { continue };
            let held = *state != TriggerState::None;
            let value = value.as_axis2d().to_array();
            if (held, value) != *last {
                *last = (held, value);
                let action = at as u16;
                self.recording.push(RecordedEvent { frame, seconds, action, held, value })?;
            }
        }
        self.recording.finish(frame, seconds)
    }
}

/// How a recording is replayed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReplayPace {
    /// A frame of the recording a frame: the same sequence on every machine.
    #[default]
    Frames,
    /// By the recording's own time: as long as it took, whatever frames take now. What was moved in the
    /// recording's frames is moved in those of the same time, all of it and no more.
    Time,
}

/// Says a recording again.
#[derive(Resource, Default)]
pub struct ActionReplay {
    playing: Option<Playing>,
}

struct Playing {
    recording: Recording,
    pace: ReplayPace,
    /// Entity and kind of each action of the recording, if the app has it.
    actions: Vec<Option<(ActionInfo, Entity)>>,
    /// What each says in this frame.
    says: Vec<(bool, Vec2)>,
    /// What each said in the frame of the recording that was last applied.
    now: Vec<(bool, Vec2)>,
    /// The next event.
    next: usize,
    frame: u64,
    seconds: f64,
    /// Frames of the recording that have been said, with a part of one.
    passed: f64,
    started: bool,
}

impl ActionReplay {
    /// Says a recording from the next frame on. Actions that this app doesn't have are left out.
    pub fn play(&mut self, recording: Recording, pace: ReplayPace) {
        let says = vec![(false, Vec2::ZERO); recording.actions().len()];
        self.playing = Some(Playing {
            recording,
            pace,
            actions: Vec::new(),
            now: says.clone(),
            says,
            next: 0,
            frame: 0,
            seconds: 0.0,
            passed: 0.0,
            started: false,
        });
    }

    /// Ends it; devices are heard again.
    pub fn stop(&mut self) {
        if let Some(playing) = &mut self.playing {
            playing.next = usize::MAX;
        }
    }

    /// Whether it goes on.
    pub fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// The frame that is said now, from 0.
    pub fn frame(&self) -> Option<u64> {
        self.playing.as_ref().map(|playing| playing.frame)
    }
}

/// Puts what the recording says into the mocks, before actions are worked out.
pub(crate) fn replay(
    mut replay: ResMut<ActionReplay>,
    entities: Res<ActionEntities>,
    mut mocks: Query<&mut ActionMock>,
    time: Res<Time<Real>>,
) {
    let Some(playing) = &mut replay.playing else { return };
    if playing.advance(&entities.all, time.delta_secs_f64()) {
        for action in &entities.all {
            if let Ok(mut mock) = mocks.get_mut(action.entity) {
                mock.enabled = false;
            }
        }
        replay.playing = None;
        return;
    }
    // Actions that the recording doesn't know are silent.
    for action in &entities.all {
        let known = playing.actions.iter().flatten().any(|(_, entity)| *entity == action.entity);
        if !known && let Ok(mut mock) = mocks.get_mut(action.entity) {
            let none = value(action.info.kind, Vec2::ZERO);
            *mock = ActionMock::new(TriggerState::None, none, MockSpan::Manual);
        }
    }
    for (action, (held, says)) in playing.actions.iter().zip(&playing.says) {
        let Some((info, entity)) = action else { continue };
        let Ok(mut mock) = mocks.get_mut(*entity) else { continue };
        let state = if *held { TriggerState::Fired } else { TriggerState::None };
        *mock = ActionMock::new(state, value(info.kind, *says), MockSpan::Manual);
    }
}

impl Playing {
    /// Goes on by a frame; whether it is over.
    fn advance(&mut self, all: &[ActionEntity], seconds: f64) -> bool {
        if self.next == usize::MAX {
            return true;
        }
        if self.actions.is_empty() {
            let find = |name: &String| {
                let action = all.iter().find(|action| action.info.name == name)?;
                Some((action.info, action.entity))
            };
            self.actions = self.recording.actions().iter().map(find).collect();
        }
        let (last_frame, last_seconds) = self.recording.end();
        match (self.pace, self.started) {
            (_, false) => {}
            (ReplayPace::Frames, true) => self.frame += 1,
            (ReplayPace::Time, true) => self.seconds += seconds,
        }
        self.started = true;
        match self.pace {
            ReplayPace::Frames => {
                self.apply_until(self.frame);
                self.frame > last_frame
            }
            ReplayPace::Time => {
                self.by_time();
                self.seconds > last_seconds
            }
        }
    }

    /// Applies all events up to a frame.
    fn apply_until(&mut self, frame: u64) {
        while let Some(event) = self.recording.events().get(self.next)
            && event.frame <= frame
        {
            self.now[usize::from(event.action)] = (event.held, Vec2::from(event.value));
            self.next += 1;
        }
        self.says.copy_from_slice(&self.now);
    }

    /// Says what was said in all frames that have passed since the last time: what was moved adds up, a
    /// button is held if it was.
    fn by_time(&mut self) {
        let until = self.frame_at(self.seconds) + 1.0;
        self.frame = until as u64 - 1;
        let mut says = std::mem::take(&mut self.says);
        says.fill((false, Vec2::ZERO));
        while self.passed < until {
            let mut now = self.passed as u64;
            // Rounding must not stop it.
            if self.passed.fract() > 1.0 - 1e-9 {
                now += 1;
            }
            while let Some(event) = self.recording.events().get(self.next)
                && event.frame <= now
            {
                self.now[usize::from(event.action)] = (event.held, Vec2::from(event.value));
                self.next += 1;
            }
            let next = self.recording.events().get(self.next);
            let next = next.map_or(until, |event| until.min(event.frame as f64));
            let frames = (next - self.passed) as f32;
            for (says, (held, value)) in says.iter_mut().zip(&self.now) {
                says.0 |= *held;
                says.1 += *value * frames;
            }
            self.passed = next;
        }
        self.says = says;
    }

    /// Which frame of the recording it was at a time, with a part of one.
    fn frame_at(&self, seconds: f64) -> f64 {
        let events = self.recording.events();
        let (end, end_seconds) = self.recording.end();
        let at = events.partition_point(|event| event.seconds <= seconds);
        let point = |event: &RecordedEvent| (event.frame as f64, event.seconds);
        let before = at.checked_sub(1).and_then(|at| events.get(at)).map_or((0.0, 0.0), point);
        let after = events.get(at).map_or((end as f64, end_seconds), point);
        let part = (seconds - before.1) / (after.1 - before.1);
        let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 1.0 };
        before.0 + part * (after.0 - before.0)
    }
}
