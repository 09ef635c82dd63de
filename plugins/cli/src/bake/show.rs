//! How far a bake is, on the terminal.

use std::{
    io::IsTerminal,
    time::{Duration, Instant},
};

use farlight_baker::{Event, Observer, Progress};
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

/// Between two lines where there is no terminal.
const EVERY: Duration = Duration::from_secs(10);
/// Steps of the bar.
const STEPS: u64 = 1000;

/// A bar on a terminal; otherwise a line now and then.
pub(super) struct Shown {
    bar: Option<ProgressBar>,
    last: Option<Instant>,
}

impl Shown {
    pub(super) fn new() -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(STEPS);
            let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}");
            if let Ok(style) = style {
                bar.set_style(style);
            }
            bar
        });
        Self { bar, last: None }
    }

    /// Leaves the terminal to others.
    pub(super) fn end(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn progress(&mut self, progress: &Progress<'_>) {
        let Progress { stage, scenario, done, left } = progress;
        let left = left.map_or(String::new(), |left| {
            format!(", {} left", HumanDuration(Duration::from_secs(left.as_secs().max(1))))
        });
        let scenario =
            if scenario.is_empty() { String::new() } else { format!(" of {scenario:?}") };
        match &self.bar {
            Some(bar) => {
                if bar.is_finished() {
                    bar.reset();
                }
                bar.set_message(format!("{stage}{scenario}{left}"));
                bar.set_position((f64::from(*done) * STEPS as f64) as u64);
            }
            None => {
                let now = Instant::now();
                // Short bakes say nothing.
                let last = *self.last.get_or_insert(now);
                if now.duration_since(last) >= EVERY {
                    self.last = Some(now);
                    eprintln!("{stage}{scenario}: {:.0} %{left}", done * 100.0);
                }
            }
        }
    }
}

impl Observer for Shown {
    fn event(&mut self, event: Event<'_>) {
        match event {
            Event::Progress(progress) => self.progress(&progress),
            Event::Warning(text) => match &self.bar {
                Some(bar) => bar.suspend(|| eprintln!("warning: {text}")),
                None => eprintln!("warning: {text}"),
            },
            Event::Idle => self.end(),
        }
    }
}
