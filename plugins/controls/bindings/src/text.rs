//! Bindings as texts: `Shift+KeyA|KeyD`.

use std::str::FromStr;

use farlight_ron::{meant, nearest};

use crate::{Binding, Held, Input, Shape, Source};

/// Why a text is no binding.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BindingError {
    /// A name that no input has.
    #[error("{name:?} is no input{}", meant(.near.as_deref()))]
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

/// Enough of a text to find it.
fn short(text: &str) -> String {
    text.chars().take(40).collect()
}

fn input(name: &str) -> Result<Input, BindingError> {
    name.trim().parse().map_err(|_| BindingError::Unknown {
        name: short(name.trim()),
        near: nearest(name.trim(), Input::all().map(|input| input.to_string())),
    })
}

impl FromStr for Binding {
    type Err = BindingError;

    fn from_str(text: &str) -> Result<Self, BindingError> {
        let mut parts: Vec<&str> = text.split('+').collect();
        let last = parts.pop().unwrap_or_default();
        if parts.len() > 3 {
            return Err(BindingError::TooMany(short(text)));
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
            _ => return Err(BindingError::Count(short(last))),
        };
        Ok(Self { held, ..Self::new(source) })
    }
}
