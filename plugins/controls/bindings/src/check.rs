//! What is wrong with bindings.

use farlight_ron::{nearest, place_of};

use crate::{ACTIONS, ActionBindings, ActionInfo, Binding, Bindings, Device, Sensitivity, Shape};

/// How bad a problem is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// May be right: only the game knows.
    Note,
    /// Works, but not as somebody may have thought.
    Warning,
    /// Does nothing, or can't be meant.
    Error,
}

/// Something wrong with bindings.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {message}")]
pub struct Problem {
    /// The field of the file: `sensitivity`, `bindings.orbit.gamepad[0]`.
    pub field: String,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, and what would be right.
    pub message: String,
}

impl Problem {
    /// Line and column of the field in a file's text, in characters, from 1; of what is round it, if
    /// it has none of its own.
    pub fn place(&self, text: &str) -> Option<(usize, usize)> {
        place_of(text, &self.field)
    }
}

/// Collects problems, not more than a person reads.
struct Problems(Vec<Problem>);

impl Problems {
    fn add(&mut self, severity: Severity, field: &str, message: impl Into<String>) {
        if self.0.len() < 100 {
            self.0.push(Problem { field: field.into(), severity, message: message.into() });
        }
    }
}

impl Bindings {
    /// What is wrong: unknown actions, inputs that don't fit or that a device doesn't have, values out
    /// of range. At most 100 problems. `added` are the game's own actions; names that are neither
    /// theirs nor the suite's are errors if they look like a slip, and notes otherwise. For inputs
    /// that do two things at once, see [`conflicts`](Self::conflicts).
    pub fn check(&self, added: &[ActionInfo]) -> Vec<Problem> {
        let mut problems = Problems(Vec::new());
        let Sensitivity(sensitivity) = self.sensitivity;
        if !(0.05..=20.0).contains(&sensitivity) {
            let message = format!("is {sensitivity}, must be 0.05 to 20");
            problems.add(Severity::Error, "sensitivity", message);
        }
        let known = |name: &str| ACTIONS.iter().chain(added).find(|info| info.name == name);
        for (at, name) in self.unused.iter().enumerate() {
            let field = format!("unused[{at}]");
            if known(name).is_none() {
                let short: String = name.chars().take(64).collect();
                unknown(&mut problems, &field, name, &format!("{short:?}: "), added);
            }
            if self.unused[..at].contains(name) {
                problems.add(Severity::Warning, &field, "is there already");
            }
        }
        for (name, own) in &self.bindings {
            let field = format!("bindings.{}", name.chars().take(64).collect::<String>());
            let info = known(name);
            if info.is_none() {
                unknown(&mut problems, &field, name, "", added);
            }
            own.check(&mut problems, &field, info);
        }
        problems.0
    }
}

/// No action has this name; `subject` says it where the field doesn't.
fn unknown(problems: &mut Problems, field: &str, name: &str, subject: &str, added: &[ActionInfo]) {
    match nearest(name, ACTIONS.iter().chain(added).map(|info| info.name)) {
        Some(near) => problems.add(
            Severity::Error,
            field,
            format!("{subject}there is no such action; did you mean {near}?"),
        ),
        None => problems.add(
            Severity::Note,
            field,
            format!("{subject}no action of the suite; good if the game adds it under this name"),
        ),
    }
}

impl ActionBindings {
    fn check(&self, problems: &mut Problems, field: &str, info: Option<&ActionInfo>) {
        for (name, bindings) in self.lists() {
            let Some(bindings) = bindings else { continue };
            for (at, binding) in bindings.iter().enumerate() {
                let field = format!("{field}.{name}[{at}]");
                let has = |input: &crate::Input| match Device::named(name) {
                    Some(device) => input.is_of(device),
                    // `xr`: any of them may have it.
                    None => matches!(input, crate::Input::Xr(..)),
                };
                if let Some(input) = binding.inputs().iter().find(|input| !has(input)) {
                    let device = Device::named(name).map_or("a headset", Device::label);
                    let message = format!("{input} is no input of this device ({device})");
                    problems.add(Severity::Error, &field, message);
                }
                if bindings[..at].contains(binding) {
                    problems.add(Severity::Warning, &field, "is there already");
                }
                if let Some(Err(error)) = info.map(|info| binding.fits(info.kind)) {
                    problems.add(Severity::Error, &field, error.to_string());
                }
                binding.check(problems, &field);
            }
        }
    }
}

impl Binding {
    fn check(&self, problems: &mut Problems, field: &str) {
        for (name, value, least, greatest) in [
            ("dead_zone", self.dead_zone, 0.0, 0.95),
            ("curve", self.curve, 0.1, 10.0),
            ("scale", self.scale, -100_000.0, 100_000.0),
        ] {
            if !(least..=greatest).contains(&value) {
                let message = format!("is {value}, must be {least} to {greatest}");
                problems.add(Severity::Error, &format!("{field}.{name}"), message);
            }
        }
        if self.scale == 0.0 {
            let message = "is 0: nothing would happen; an empty list binds nothing";
            problems.add(Severity::Error, &format!("{field}.scale"), message);
        }
        let plain = Self::new(self.source);
        let analog = |input: &crate::Input| matches!(input.shape(), Shape::Analog | Shape::Stick);
        let bent = self.dead_zone != plain.dead_zone || self.curve != plain.curve;
        if bent && !self.source.inputs().iter().any(analog) {
            let message =
                "dead_zone and curve are for sticks and triggers: they change nothing here";
            problems.add(Severity::Warning, field, message);
        }
        let inputs = self.inputs();
        if inputs.iter().enumerate().any(|(at, input)| inputs[..at].contains(input)) {
            let message = format!("{:?} has an input twice", self.input_text());
            problems.add(Severity::Error, field, message);
        }
    }
}
