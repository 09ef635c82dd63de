//! One binding: which input, what has to be held with it, and how its values are treated.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser::SerializeStruct};

use crate::{ActionKind, Input, Key, Shape};

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

    /// What people read.
    pub fn label(self) -> String {
        match self {
            Self::Input(input) => input.label(),
            other => other.to_string(),
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
        let wants = |held: &Held| other.held.contains(held);
        let more = other.held.iter().any(|held| !self.held.contains(held));
        more && self.held.iter().all(wants) && self.shares_source(other)
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

    /// What people read: `Shift + A / D`.
    pub fn label(&self) -> String {
        let mut text = String::new();
        for held in &self.held {
            text += &format!("{} + ", held.label());
        }
        let inputs: Vec<_> = self.source.inputs().iter().map(|input| input.label()).collect();
        text + &inputs.join(" / ")
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

/// Why a text is no binding.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BindingError {
    /// A name that no input has.
    #[error("{name:?} is no input{}", .near.as_ref().map(|n| format!("; did you mean {n}?")).unwrap_or_default())]
    Unknown {
        /// The name.
        name: String,
        /// The most similar one.
        near: Option<String>,
    },
    /// Three inputs, or more than four.
    #[error("{0:?}: write one input, two for less and more, or four for left, right, down and up")]
    Count(String),
    /// What is held can't be held.
    #[error("{0:?} can't be held: only buttons can")]
    NoButton(String),
    /// More than three inputs to hold.
    #[error("{0:?}: more than three inputs to hold")]
    TooMany(String),
    /// It doesn't give what the action needs.
    #[error("{input:?} does not fit: the action wants {wanted}")]
    Unfit {
        /// The inputs.
        input: String,
        /// What would do.
        wanted: &'static str,
    },
}

fn input(name: &str) -> Result<Input, BindingError> {
    name.trim().parse().map_err(|_| BindingError::Unknown {
        name: name.trim().to_owned(),
        near: nearest(name.trim()),
    })
}

/// The name with the fewest differences, if they are few.
fn nearest(name: &str) -> Option<String> {
    if name.len() > 40 {
        return None;
    }
    let names = Input::all().map(|input| input.to_string());
    let (distance, near) = names.map(|near| (edits(name, &near), near)).min()?;
    (distance <= 3 && distance < name.len()).then_some(near)
}

/// Levenshtein's distance, without regard to case.
fn edits(a: &str, b: &str) -> usize {
    let (a, b) = (a.to_lowercase(), b.to_lowercase());
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut before = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let change = before + usize::from(x != *y);
            before = row[j + 1];
            row[j + 1] = change.min(before + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

impl FromStr for Binding {
    type Err = BindingError;

    fn from_str(text: &str) -> Result<Self, BindingError> {
        let mut parts: Vec<&str> = text.split('+').collect();
        let last = parts.pop().unwrap_or_default();
        if parts.len() > 3 {
            return Err(BindingError::TooMany(text.to_owned()));
        }
        let held = parts.into_iter().map(|part| match part.trim() {
            "Shift" => Ok(Held::Shift),
            "Ctrl" => Ok(Held::Ctrl),
            "Alt" => Ok(Held::Alt),
            name => match input(name)? {
                input if matches!(input.shape(), Shape::Button | Shape::Analog) => {
                    Ok(Held::Input(input))
                }
                input => Err(BindingError::NoButton(input.to_string())),
            },
        });
        let held = held.collect::<Result<Vec<_>, _>>()?;
        let inputs = last.split('|').map(input).collect::<Result<Vec<_>, _>>()?;
        let source = match inputs[..] {
            [one] => Source::One(one),
            [less, more] => Source::Pair([less, more]),
            [left, right, down, up] => Source::Four([left, right, down, up]),
            _ => return Err(BindingError::Count(last.to_owned())),
        };
        Ok(Self { held, ..Self::new(source) })
    }
}

impl Serialize for Binding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.is_plain() {
            return serializer.serialize_str(&self.input_text());
        }
        let plain = Self::new(self.source);
        let mut fields = serializer.serialize_struct("Binding", 6)?;
        fields.serialize_field("input", &self.input_text())?;
        if self.dead_zone != plain.dead_zone {
            fields.serialize_field("dead_zone", &self.dead_zone)?;
        }
        if self.curve != plain.curve {
            fields.serialize_field("curve", &self.curve)?;
        }
        if self.scale != plain.scale {
            fields.serialize_field("scale", &self.scale)?;
        }
        if self.invert_x {
            fields.serialize_field("invert_x", &true)?;
        }
        if self.invert_y {
            fields.serialize_field("invert_y", &true)?;
        }
        fields.end()
    }
}

impl<'de> Deserialize<'de> for Binding {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;

        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Binding;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an input such as \"KeyM\", or (input: \"LeftStick\", scale: 90.0)")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Binding, E> {
                text.parse().map_err(E::custom)
            }

            fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<Binding, A::Error> {
                let fields = Fields::deserialize(de::value::MapAccessDeserializer::new(map))?;
                let mut binding: Binding = fields.input.parse().map_err(de::Error::custom)?;
                binding.dead_zone = fields.dead_zone.unwrap_or(binding.dead_zone);
                binding.curve = fields.curve.unwrap_or(binding.curve);
                binding.scale = fields.scale.unwrap_or(binding.scale);
                binding.invert_x = fields.invert_x;
                binding.invert_y = fields.invert_y;
                Ok(binding)
            }
        }

        deserializer.deserialize_any(Visitor)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    input: String,
    #[serde(default)]
    dead_zone: Option<f32>,
    #[serde(default)]
    curve: Option<f32>,
    #[serde(default)]
    scale: Option<f32>,
    #[serde(default)]
    invert_x: bool,
    #[serde(default)]
    invert_y: bool,
}
