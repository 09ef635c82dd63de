//! What a type says of its fields, for people.

use std::ops::RangeInclusive;

use bevy::{
    prelude::*,
    reflect::{NamedField, UnnamedField, attributes::CustomAttributes},
};
use farlight_core::field::{Logarithmic, Step, Unit};

use super::Spec;

/// What a type says of a field.
#[derive(Clone, Copy, Default)]
pub(crate) struct About<'a> {
    pub(super) attributes: Option<&'a CustomAttributes>,
    pub(super) docs: Option<&'a str>,
}

impl<'a> About<'a> {
    pub(super) fn named(field: Option<&'a NamedField>) -> Self {
        Self {
            attributes: field.map(NamedField::custom_attributes),
            docs: field.and_then(NamedField::docs),
        }
    }

    pub(super) fn unnamed(field: Option<&'a UnnamedField>) -> Self {
        Self {
            attributes: field.map(UnnamedField::custom_attributes),
            docs: field.and_then(UnnamedField::docs),
        }
    }

    pub(super) fn get<T: Reflect>(&self) -> Option<&'a T> {
        self.attributes?.get::<T>()
    }

    pub(super) fn has<T: Reflect>(&self) -> bool {
        self.get::<T>().is_some()
    }

    pub(super) fn spec(&self, range: Option<RangeInclusive<f64>>, integer: bool) -> Spec {
        Spec {
            range,
            integer,
            unit: self.get::<Unit>().map_or("", |unit| unit.0),
            step: self.get::<Step>().map(|step| step.0),
            logarithmic: self.has::<Logarithmic>(),
        }
    }
}

/// A name of code as people write it: `per_frame` and `PerFrame` are "Per frame".
pub(crate) fn words(name: &str) -> String {
    let mut text = String::new();
    for letter in name.trim_start_matches("r#").chars() {
        if letter == '_' {
            text.push(' ');
        } else if letter.is_uppercase() && !text.is_empty() {
            text.push(' ');
            text.extend(letter.to_lowercase());
        } else if text.is_empty() {
            text.extend(letter.to_uppercase());
        } else {
            text.push(letter);
        }
    }
    text
}

/// Documentation as a tooltip: without Rust's links and code marks.
pub(super) fn plain(docs: &str) -> String {
    let mut text = String::new();
    for line in docs.trim().lines() {
        let line = line.trim();
        match line {
            "" => text.push_str("\n\n"),
            _ => {
                if !text.is_empty() && !text.ends_with('\n') {
                    text.push(' ');
                }
                text.push_str(line);
            }
        }
    }
    // `[text](target)` is its text, and so is `[text]`.
    let mut out = String::new();
    let mut rest = text.as_str();
    while let Some(open) = rest.find('[') {
        out.push_str(&rest[..open]);
        rest = &rest[open + 1..];
        let Some(close) = rest.find(']') else { break };
        out.push_str(&rest[..close]);
        rest = &rest[close + 1..];
        if let Some(target) = rest.strip_prefix('(')
            && let Some(end) = target.find(')')
        {
            rest = &target[end + 1..];
        }
    }
    out.push_str(rest);
    out.replace('`', "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_documentation_are_for_people() {
        assert_eq!(words("per_frame"), "Per frame");
        assert_eq!(words("LightmapOnly"), "Lightmap only");
        let docs = " Lights ([`LIGHTS`](crate::LIGHTS)); `more` is\n closer.\n\n Another.";
        assert_eq!(plain(docs), "Lights (LIGHTS); more is closer.\n\nAnother.");
    }
}
