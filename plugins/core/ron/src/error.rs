//! What is wrong with a text, in words that a person can act on.

use serde::de::DeserializeOwned;

use crate::{
    near::{meant, nearest},
    places::{field_at, place_of, token_at},
};

/// Why a text can't be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{line}:{column}: {}{message}", prefix(.field))]
pub struct FileError {
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
    /// The field: `bindings.orbit.gamepad[0]`; empty if it lies in none.
    pub field: String,
    /// What is wrong, and what may have been meant.
    pub message: String,
}

fn prefix(field: &str) -> String {
    if field.is_empty() { String::new() } else { format!("{field}: ") }
}

impl FileError {
    /// What a parser said about `text`.
    pub fn new(text: &str, error: &ron::error::SpannedError) -> Self {
        let start = error.span.start;
        let (line, column) = token_at(text, (start.line, start.col));
        let field = field_at(text, (line, column));
        Self { line, column, field, message: message(&error.code) }
    }

    /// What a check of one's own says about a field of `text`: `all[0].watts`. The place is that of the
    /// nearest field round it where it is not there itself.
    pub fn of_field(text: &str, field: impl Into<String>, message: impl Into<String>) -> Self {
        let field = field.into();
        let (line, column) = place_of(text, &field).unwrap_or((1, 1));
        Self { line, column, field, message: message.into() }
    }
}

/// Reads a value.
///
/// # Errors
/// Says where something is that doesn't belong there.
pub fn parse<T: DeserializeOwned>(text: &str) -> Result<T, FileError> {
    ron::from_str(text).map_err(|error| FileError::new(text, &error))
}

fn message(code: &ron::Error) -> String {
    use ron::Error as E;
    let known = |what: &str, found: &String, expected: &[&str]| {
        let near = nearest(found, expected.iter().filter(|name| **name != found));
        let others = match near {
            Some(near) => meant(Some(&near)),
            None => format!("; there are {}", expected.join(", ")),
        };
        let found: String = found.chars().take(40).collect();
        format!("there is no {what} {found:?}{others}")
    };
    match code {
        E::NoSuchStructField { expected, found, .. } => known("field", found, expected),
        E::NoSuchEnumVariant { expected, found, .. } => known("value", found, expected),
        E::MissingStructField { field, .. } => format!("{field} is missing"),
        E::DuplicateStructField { field, .. } => format!("{field} is there twice"),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Deserialize, Debug, Default, PartialEq)]
    #[serde(default, deny_unknown_fields)]
    struct Lamp {
        watts: f32,
        kind: Kind,
        more: Vec<Self>,
    }

    #[derive(Deserialize, Debug, Default, PartialEq)]
    enum Kind {
        #[default]
        Bulb,
        Tube(f32),
    }

    #[test]
    fn errors_say_where_and_what_was_meant() {
        for (text, error) in [
            ("Lamp(wats: 1.0)", "1:6: wats: there is no field \"wats\"; did you mean watts?"),
            (
                "Lamp(\n  volts: 1.0)",
                "2:3: volts: there is no field \"volts\"; there are watts, kind, more",
            ),
            (
                "Lamp(more: [(), (kind: Blub)])",
                "1:24: more[1].kind: there is no value \"Blub\"; did you mean Bulb?",
            ),
            ("Lamp(watts: 1, watts: 2)", "1:16: watts: watts is there twice"),
        ] {
            let found = parse::<Lamp>(text).unwrap_err().to_string();
            assert_eq!(found, error, "{text}");
        }
        assert_eq!(
            parse("Lamp(kind: Tube(1.5))"),
            Ok(Lamp { kind: Kind::Tube(1.5), ..Lamp::default() })
        );
    }

    #[test]
    fn every_text_has_an_error_within_it() {
        let good = "/* é */ Lamp(watts: 1.0, more: [(kind: Tube(2)), (watts: \"x\")])";
        for (end, _) in good.char_indices() {
            let error = parse::<Lamp>(&good[..end]).unwrap_err();
            assert!(error.line == 1 && error.column <= end + 1, "{end}: {error}");
        }
    }
}
