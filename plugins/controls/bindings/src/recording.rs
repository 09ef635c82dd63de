//! What actions said, frame by frame, as a text that can be kept, compared and replayed.
//!
//! ```text
//! farlight-recording 1
//! actions orbit next_material
//! 12 0.2 0=3.5,-1 1=1
//! 13 0.2166667 0 1
//! 240 4
//! ```
//!
//! The second line names the actions; events name them by their place, from 0. A line a frame in which
//! something changed: its number and its time in seconds, both since the start, then events. `0=3.5,-1`
//! is held and says so, `1=1` is a button that is down, `1` one that was let go. (`2~0.5` has a value
//! without being held.) An action stays as it is until its next event. The last line may have none: it
//! says when the recording ended. Empty lines and lines that begin with `#` are passed over.

use std::{fmt, str::FromStr};

/// Most actions of a recording.
pub const MAX_RECORDED_ACTIONS: usize = 1024;
/// Most events of a recording: an hour and a half of three that change in every 60th of a second.
pub const MAX_RECORDED_EVENTS: usize = 1 << 20;
/// Longest name of an action, in bytes.
const MAX_NAME: usize = 64;
const HEAD: &str = "farlight-recording 1";

/// An action changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedEvent {
    /// The number of the frame since the start, from 0.
    pub frame: u64,
    /// The time of the frame since the start, in seconds.
    pub seconds: f64,
    /// Which action: a place in [`Recording::actions`].
    pub action: u16,
    /// Whether it is held from now on.
    pub held: bool,
    /// Its value from now on, in its unit: of a button 1 or 0 and 0, of an axis the number and 0.
    pub value: [f32; 2],
}

/// What actions said: written with [`fmt::Display`], read with [`FromStr`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    actions: Vec<String>,
    events: Vec<RecordedEvent>,
    end: (u64, f64),
}

/// A frame of a recording in which something changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedFrame<'a> {
    /// Its number since the start, from 0.
    pub frame: u64,
    /// Its time since the start, in seconds.
    pub seconds: f64,
    /// What changed, at least one.
    pub events: &'a [RecordedEvent],
}

impl Recording {
    /// An empty recording of actions with these names.
    ///
    /// # Errors
    /// If there are too many, one is there twice, or a name is empty, longer than 64 bytes, or made of
    /// anything but lower-case letters, digits and underscores.
    pub fn new<S: Into<String>>(
        actions: impl IntoIterator<Item = S>,
    ) -> Result<Self, RecordingError> {
        let mut recording = Self::default();
        for name in actions {
            let name = name.into();
            let plain = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'_';
            if name.is_empty() || name.len() > MAX_NAME || !name.bytes().all(plain) {
                return Err(RecordingError::Name(short(&name)));
            }
            if recording.actions.len() == MAX_RECORDED_ACTIONS {
                return Err(RecordingError::TooManyActions);
            }
            recording.actions.push(name);
        }
        let mut sorted: Vec<_> = recording.actions.iter().collect();
        sorted.sort();
        match sorted.windows(2).find(|two| two[0] == two[1]) {
            Some(two) => Err(RecordingError::Twice(two[0].clone())),
            None => Ok(recording),
        }
    }

    /// The names of its actions.
    pub fn actions(&self) -> &[String] {
        &self.actions
    }

    /// The place of an action in it.
    pub fn action(&self, name: &str) -> Option<u16> {
        self.actions.iter().position(|action| action == name).map(|at| at as u16)
    }

    /// What changed, in order.
    pub fn events(&self) -> &[RecordedEvent] {
        &self.events
    }

    /// The frame and the time of its end, since the start.
    pub fn end(&self) -> (u64, f64) {
        self.end
    }

    /// Adds what changed in a frame.
    ///
    /// # Errors
    /// If the recording is full, there is no such action, a number is not finite, or the frame lies
    /// before one that is already there or has another time.
    pub fn push(&mut self, event: RecordedEvent) -> Result<(), RecordingError> {
        if usize::from(event.action) >= self.actions.len() {
            return Err(RecordingError::Action(event.action.into()));
        }
        if !event.value.iter().all(|value| value.is_finite()) {
            return Err(RecordingError::NotFinite);
        }
        let of_frame = self.events.iter().rev().take_while(|last| last.frame == event.frame);
        if of_frame.into_iter().any(|last| last.action == event.action) {
            return Err(RecordingError::TwiceInFrame(event.action));
        }
        if self.events.len() == MAX_RECORDED_EVENTS {
            return Err(RecordingError::TooManyEvents);
        }
        self.finish(event.frame, event.seconds)?;
        self.events.push(event);
        Ok(())
    }

    /// Says that it goes on to this frame.
    ///
    /// # Errors
    /// If the time is not finite, or the frame lies before one that is already there or has another
    /// time.
    pub fn finish(&mut self, frame: u64, seconds: f64) -> Result<(), RecordingError> {
        if !seconds.is_finite() || seconds < 0.0 {
            return Err(RecordingError::NotFinite);
        }
        let (last, last_seconds) = self.end;
        let began = self.events.is_empty() && self.end == (0, 0.0);
        let same = frame == last && seconds == last_seconds;
        let later = frame > last && seconds >= last_seconds;
        if !(began || same || later) {
            return Err(RecordingError::Order);
        }
        self.end = (frame, seconds);
        Ok(())
    }

    /// The frames in which something changed, in order.
    pub fn frames(&self) -> impl Iterator<Item = RecordedFrame<'_>> {
        self.events.chunk_by(|a, b| a.frame == b.frame).map(|events| RecordedFrame {
            frame: events[0].frame,
            seconds: events[0].seconds,
            events,
        })
    }
}

impl fmt::Display for Recording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{HEAD}")?;
        f.write_str("actions")?;
        for name in &self.actions {
            write!(f, " {name}")?;
        }
        let mut last = None;
        for RecordedFrame { frame, seconds, events } in self.frames() {
            write!(f, "\n{frame} {seconds}")?;
            last = Some(frame);
            for RecordedEvent { action, held, value: [x, y], .. } in events {
                // Negative zero is a number too, and comes back as it was.
                let value = match (x.to_bits(), y.to_bits()) {
                    (_, 0) => format!("{x}"),
                    _ => format!("{x},{y}"),
                };
                match (held, value.as_str()) {
                    (false, "0") => write!(f, " {action}")?,
                    (false, value) => write!(f, " {action}~{value}")?,
                    (true, value) => write!(f, " {action}={value}")?,
                }
            }
        }
        let (frame, seconds) = self.end;
        if last.is_none_or(|last| last < frame) && self.end != (0, 0.0) {
            write!(f, "\n{frame} {seconds}")?;
        }
        writeln!(f)
    }
}

impl FromStr for Recording {
    type Err = RecordingFileError;

    fn from_str(text: &str) -> Result<Self, RecordingFileError> {
        let lines = text.lines().enumerate();
        let mut lines = lines.filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
        let at = |line: usize| move |error| RecordingFileError { line: line + 1, error };
        let (line, head) = lines.next().unwrap_or_default();
        if head.trim_end() != HEAD {
            return Err(at(line)(RecordingError::Head));
        }
        let (line, names) = lines.next().unwrap_or((line + 1, ""));
        let mut names = names.split_whitespace();
        if names.next() != Some("actions") {
            return Err(at(line)(RecordingError::Actions));
        }
        let mut recording = Self::new(names).map_err(at(line))?;
        for (line, text) in lines {
            recording.read_frame(text).map_err(at(line))?;
        }
        Ok(recording)
    }
}

impl Recording {
    fn read_frame(&mut self, line: &str) -> Result<(), RecordingError> {
        let mut words = line.split_whitespace();
        let frame = number(words.next().unwrap_or_default())?;
        let seconds = number(words.next().unwrap_or_default())?;
        if self.events.last().is_some_and(|last| last.frame == frame) {
            return Err(RecordingError::Order);
        }
        self.finish(frame, seconds)?;
        words.try_for_each(|word| {
            let (action, held, value) = match word.find(['=', '~']) {
                Some(at) => (&word[..at], word[at..].starts_with('='), &word[at + 1..]),
                None => (word, false, "0"),
            };
            let (x, y) = value.split_once(',').unwrap_or((value, "0"));
            let value = [number(x)?, number(y)?];
            let action: usize = number(action)?;
            let action = u16::try_from(action).map_err(|_| RecordingError::Action(action))?;
            self.push(RecordedEvent { frame, seconds, action, held, value })
        })
    }
}

fn number<T: FromStr>(text: &str) -> Result<T, RecordingError> {
    text.parse().map_err(|_| RecordingError::Number(short(text)))
}

/// Enough of a text to find it.
fn short(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Why there is no such recording.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecordingError {
    /// The first line is another.
    #[error("this is no recording: the first line must be {HEAD:?}")]
    Head,
    /// The second line is another.
    #[error("the second line must be \"actions\" and their names")]
    Actions,
    /// A name that no action can have.
    #[error(
        "{0:?} can't be an action's name: 1 to 64 lower-case letters, digits and underscores can"
    )]
    Name(String),
    /// A name is there twice.
    #[error("the action {0} is named twice")]
    Twice(String),
    /// More than [`MAX_RECORDED_ACTIONS`].
    #[error("more than {MAX_RECORDED_ACTIONS} actions")]
    TooManyActions,
    /// More than [`MAX_RECORDED_EVENTS`].
    #[error("more than {MAX_RECORDED_EVENTS} events")]
    TooManyEvents,
    /// An action that is not named.
    #[error("there is no action {0}")]
    Action(usize),
    /// An action changes twice in a frame.
    #[error("action {0} changes twice in this frame")]
    TwiceInFrame(u16),
    /// Not a number.
    #[error("{0:?} is no number that fits here")]
    Number(String),
    /// A number that is infinite or none; a time before the start.
    #[error("values must be finite, and times not negative")]
    NotFinite,
    /// A frame before the one before.
    #[error("frames must follow each other, their times too")]
    Order,
}

/// Why a text is no recording.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {error}")]
pub struct RecordingFileError {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong there.
    #[source]
    pub error: RecordingError,
}
