//! One binding: which input, what has to be held with it, and how its values are treated.

use std::fmt;

use crate::{ActionKind, BindingError, Input, Key, Shape};

/// What an action's value is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// One input.
    One(Input),
    /// Less and more: `KeyA|KeyD`.
    Pair([Input; 2]),
    /// Left, right, down and up: `KeyA|KeyD|KeyS|KeyW`.
    Four([Input; 4]),
}

impl Source {
    /// Its inputs.
    pub fn inputs(&self) -> &[Input] {
        match self {
            Self::One(input) => std::slice::from_ref(input),
            Self::Pair(inputs) => inputs,
            Self::Four(inputs) => inputs,
        }
    }
}

/// What must be held for a binding to count. While it is held, bindings of the same inputs that ask
/// for less are silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Held {
    /// Either Shift key: `Shift+`.
    Shift,
    /// Either Ctrl key: `Ctrl+`.
    Ctrl,
    /// Either Alt key: `Alt+`.
    Alt,
    /// Any other button.
    Input(Input),
}

impl Held {
    /// The inputs of which one must be down.
    pub fn inputs(self) -> Vec<Input> {
        let keys = |names: [&str; 2]| {
            names.iter().filter_map(|name| Key::named(name).map(Input::Key)).collect()
        };
        match self {
            Self::Shift => keys(["ShiftLeft", "ShiftRight"]),
            Self::Ctrl => keys(["ControlLeft", "ControlRight"]),
            Self::Alt => keys(["AltLeft", "AltRight"]),
            Self::Input(input) => vec![input],
        }
    }

    /// Whether `other` is held whenever this is: the same, or one of its keys.
    fn implies(self, other: Self) -> bool {
        match (self, other) {
            (Self::Input(key), Self::Shift | Self::Ctrl | Self::Alt) => {
                other.inputs().contains(&key)
            }
            _ => self == other,
        }
    }
}

impl fmt::Display for Held {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shift => f.write_str("Shift"),
            Self::Ctrl => f.write_str("Ctrl"),
            Self::Alt => f.write_str("Alt"),
            Self::Input(input) => input.fmt(f),
        }
    }
}

/// An input bound to an action. In files it is a text, `"Shift+KeyM"`, or, where values are treated,
/// `(input: "LeftStick", dead_zone: 0.15, curve: 2.0, scale: 120.0, invert_y: true)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// What must be held.
    pub held: Vec<Held>,
    /// What moves.
    pub source: Source,
    /// Values below this count as none, 0 to 0.95; the rest is stretched, so that nothing jumps. Of
    /// sticks and triggers; on buttons, how far a trigger must be pressed (by default half).
    pub dead_zone: f32,
    /// Power by which values from 0 to 1 are bent, 0.1 to 10: above 1 small moves are finer. Of sticks
    /// and triggers.
    pub curve: f32,
    /// Factor, -100000 to 100000. What is held gives this much of the action's unit a second; what
    /// moves gives this much for each unit of its own.
    pub scale: f32,
    /// Whether left and right are exchanged; less and more, of a single number.
    pub invert_x: bool,
    /// Whether up and down are exchanged.
    pub invert_y: bool,
}

impl Binding {
    /// A binding of `source`, values as they are.
    pub fn new(source: Source) -> Self {
        let analog = match source {
            Source::One(input) => input.shape() == Shape::Stick,
            // A button that is half of a stick's way counts from a half.
            _ => source.inputs().iter().any(|input| input.stick().is_some()),
        };
        Self {
            held: Vec::new(),
            source,
            dead_zone: if analog { 0.15 } else { 0.0 },
            curve: 1.0,
            scale: 1.0,
            invert_x: false,
            invert_y: false,
        }
    }

    /// Whether `other` silences this one while all that it wants held is held: it needs the same
    /// input, and wants what this one wants and more. `LeftDrag` is masked by `Ctrl+LeftDrag`; neither
    /// masks `Shift+LeftDrag`. Whoever lets go of Ctrl before the mouse's button wants no other move:
    /// what is masked should stay silent until its inputs are let go.
    pub fn is_masked_by(&self, other: &Self) -> bool {
        other.wants_all_of(self) && !self.wants_all_of(other) && self.shares_source(other)
    }

    /// Whether all that `other` wants held is held when all is that this one wants.
    pub(crate) fn wants_all_of(&self, other: &Self) -> bool {
        other.held.iter().all(|held| self.held.iter().any(|own| own.implies(*held)))
    }

    /// Whether one of the inputs that move it moves `other` too; what is held doesn't matter.
    pub fn shares_source(&self, other: &Self) -> bool {
        let others = other.source.inputs();
        self.source.inputs().iter().any(|input| others.iter().any(|o| o.overlaps(*input)))
    }

    /// Whether only the inputs matter.
    pub fn is_plain(&self) -> bool {
        let plain = Self { held: self.held.clone(), ..Self::new(self.source) };
        *self == plain
    }

    /// All inputs, those to hold as well.
    pub fn inputs(&self) -> Vec<Input> {
        let held = self.held.iter().flat_map(|held| held.inputs());
        held.chain(self.source.inputs().iter().copied()).collect()
    }

    /// The inputs as files write them: `Shift+KeyA|KeyD`.
    pub fn input_text(&self) -> String {
        let mut text = String::new();
        for held in &self.held {
            text += &format!("{held}+");
        }
        let inputs: Vec<_> = self.source.inputs().iter().map(Input::to_string).collect();
        text + &inputs.join("|")
    }

    /// Whether it can drive an action of a kind.
    ///
    /// # Errors
    /// Says which inputs would fit.
    pub fn fits(&self, kind: ActionKind) -> Result<(), BindingError> {
        let pressed = |input: &Input| matches!(input.shape(), Shape::Button | Shape::Analog);
        let fits = match (kind, &self.source) {
            (ActionKind::Button, Source::One(input)) => pressed(input),
            (ActionKind::Axis, Source::One(_)) => true,
            (ActionKind::Axis, Source::Pair(inputs)) => inputs.iter().all(pressed),
            (ActionKind::Axis2, Source::One(input)) => {
                matches!(input.shape(), Shape::Stick | Shape::Delta2)
            }
            (ActionKind::Axis2, Source::Four(inputs)) => inputs.iter().all(pressed),
            _ => false,
        };
        if fits {
            return Ok(());
        }
        Err(BindingError::Unfit {
            input: self.input_text(),
            wanted: match kind {
                ActionKind::Button => "one button",
                ActionKind::Axis => "one input, or two buttons for less and more: KeyA|KeyD",
                ActionKind::Axis2 => {
                    "a stick, a drag, or four buttons for left, right, down, up: KeyA|KeyD|KeyS|KeyW"
                }
            },
        })
    }
}
