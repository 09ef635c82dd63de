//! Configuration files in RON, loaded as assets.

use std::marker::PhantomData;

use bevy::{
    asset::{AssetLoader, LoadContext, io::Reader},
    prelude::*,
};
use farlight_ron::{FileError, place_of};
use serde::de::DeserializeOwned;
use thiserror::Error;

/// A value out of its range.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{field}: {message}")]
pub struct FieldProblem {
    /// The field's path as it stands in the file: `camera.position`, `models[2].size`.
    pub field: String,
    /// What is wrong and what would be right.
    pub message: String,
}

impl FieldProblem {
    /// A problem with `field`.
    pub fn new(field: impl Into<String>, message: impl Into<String>) -> Self {
        Self { field: field.into(), message: message.into() }
    }
}

/// A type that can stand alone in a RON file. Derive serde's `Deserialize` with
/// `#[serde(default, deny_unknown_fields)]`, so that every field may be left out and none misspelt.
pub trait RonSettings: Asset + DeserializeOwned {
    /// File name extensions without the first dot, for example `gi.ron`.
    const EXTENSIONS: &'static [&'static str];

    /// Checks ranges.
    ///
    /// # Errors
    /// The first field whose value can't be used.
    fn check(&self) -> Result<(), FieldProblem> {
        Ok(())
    }
}

/// Why a configuration file was refused. The last good values stay in use.
#[derive(Debug, Error)]
pub enum RonError {
    /// The file can't be read.
    #[error("{file}: {source}")]
    Io {
        /// Which file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// It isn't UTF-8.
    #[error("{file}: not UTF-8 text (byte {byte})")]
    NotText {
        /// Which file.
        file: String,
        /// Where the text ends.
        byte: usize,
    },
    /// It isn't what the type expects: syntax, an unknown field, a value of another kind.
    #[error("{file}:{line}:{column}: {}{message}", field.as_ref().map(|f| format!("{f}: ")).unwrap_or_default())]
    Parse {
        /// Which file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The field that was being read, where there was one: `models[2].size`.
        field: Option<String>,
        /// What is wrong.
        message: String,
    },
    /// A value is out of its range.
    #[error("{file}{}: {problem}", line.map(|l| format!(":{l}")).unwrap_or_default())]
    Range {
        /// Which file.
        file: String,
        /// The line that sets the field, or the nearest one round it; `None` if none is set there.
        line: Option<usize>,
        /// The field and what is wrong.
        problem: FieldProblem,
    },
}

/// Parses and checks settings; `file` is only used in errors.
///
/// # Errors
/// [`RonError::Parse`] and [`RonError::Range`].
pub fn parse_ron<T: RonSettings>(file: &str, text: &str) -> Result<T, RonError> {
    let value: T = farlight_ron::parse(text).map_err(|error| {
        let FileError { line, column, field, message } = error;
        let field = (!field.is_empty()).then_some(field);
        RonError::Parse { file: file.to_owned(), line, column, field, message }
    })?;
    value.check().map_err(|problem| RonError::Range {
        file: file.to_owned(),
        line: place_of(text, &problem.field).map(|(line, _)| line),
        problem,
    })?;
    Ok(value)
}

/// Loads `T` from RON files. Changes of the file reach [`Assets<T>`](Assets) when the asset server
/// watches files.
#[derive(TypePath)]
pub struct RonLoader<T: RonSettings>(PhantomData<fn() -> T>);

impl<T: RonSettings> Default for RonLoader<T> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<T: RonSettings> AssetLoader for RonLoader<T> {
    type Asset = T;
    type Settings = ();
    type Error = RonError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        load_context: &mut LoadContext<'_>,
    ) -> Result<T, RonError> {
        let file = load_context.path().to_string();
        let mut bytes = Vec::new();
        reader
            .read_to_end(&mut bytes)
            .await
            .map_err(|source| RonError::Io { file: file.clone(), source })?;
        let text = String::from_utf8(bytes).map_err(|error| RonError::NotText {
            file: file.clone(),
            byte: error.utf8_error().valid_up_to(),
        })?;
        parse_ron(&file, &text)
    }

    fn extensions(&self) -> &[&str] {
        T::EXTENSIONS
    }
}

/// Registers `T` as an asset that RON files hold.
pub struct RonPlugin<T: RonSettings>(PhantomData<fn() -> T>);

impl<T: RonSettings> Default for RonPlugin<T> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<T: RonSettings> Plugin for RonPlugin<T> {
    fn build(&self, app: &mut App) {
        app.init_asset::<T>().register_asset_loader(RonLoader::<T>::default());
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Asset, TypePath, Deserialize, Debug, PartialEq)]
    #[serde(default, deny_unknown_fields)]
    struct Lamp {
        watts: f32,
        name: String,
    }

    impl Default for Lamp {
        fn default() -> Self {
            Self { watts: 60.0, name: "lamp".into() }
        }
    }

    impl RonSettings for Lamp {
        const EXTENSIONS: &'static [&'static str] = &["lamp.ron"];

        fn check(&self) -> Result<(), FieldProblem> {
            if self.watts < 0.0 {
                return Err(FieldProblem::new("watts", "must not be negative"));
            }
            Ok(())
        }
    }

    fn error(text: &str) -> String {
        parse_ron::<Lamp>("a.lamp.ron", text).unwrap_err().to_string()
    }

    #[test]
    fn fields_have_defaults_and_the_outer_name_is_checked() {
        assert_eq!(parse_ron::<Lamp>("a", "Lamp(watts: 5.0)").unwrap().name, "lamp");
        assert_eq!(parse_ron::<Lamp>("a", "()").unwrap(), Lamp::default());
        let other = error("Candle(watts: 5.0)");
        assert!(other.contains("a.lamp.ron:1:") && other.contains("Lamp"), "{other}");
    }

    #[test]
    fn errors_name_file_line_and_field() {
        let unknown = error("Lamp(\n    watts: 5.0,\n    volts: 230.0,\n)");
        assert!(unknown.starts_with("a.lamp.ron:3:") && unknown.contains("volts"), "{unknown}");
        let kind = error("Lamp(\n    watts: \"bright\",\n)");
        assert!(kind.starts_with("a.lamp.ron:2:") && kind.contains("watts"), "{kind}");
        let range = error("Lamp(\n    // watts: 1\n    watts: -1.0,\n)");
        assert_eq!(range, "a.lamp.ron:3: watts: must not be negative");
        let syntax = error("Lamp(\n    watts 5.0\n)");
        assert!(syntax.starts_with("a.lamp.ron:2:"), "{syntax}");
    }
}
