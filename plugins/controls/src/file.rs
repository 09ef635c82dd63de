//! A file of bindings as an asset.

use std::io;

use bevy::{
    asset::{AssetLoader, LoadContext, io::Reader},
    prelude::*,
};
use farlight_bindings::{Bindings, FileError};
use thiserror::Error;

/// A file of bindings as an asset, `ControlsSettings(...)` in RON.
#[derive(Asset, TypePath, Clone, Debug, Default, PartialEq)]
pub struct ControlsFile {
    /// What differs from the defaults.
    pub bindings: Bindings,
    /// The file's name.
    pub file: String,
    /// Its text, so that problems can say where they are.
    pub text: String,
}

/// Why a file of bindings was refused. The last good bindings count.
#[derive(Debug, Error)]
pub enum ControlsFileError {
    /// It can't be read.
    #[error("{file}: {error}")]
    Io {
        /// Which file.
        file: String,
        /// Why.
        error: io::Error,
    },
    /// It isn't what it should be.
    #[error("{file}:{error}")]
    Text {
        /// Which file.
        file: String,
        /// Where and what.
        error: FileError,
    },
}

/// Reads a file; `file` is only used in errors.
pub(crate) fn parse(file: &str, bytes: Vec<u8>) -> Result<ControlsFile, ControlsFileError> {
    let file = file.to_owned();
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            let error = io::Error::new(io::ErrorKind::InvalidData, error.utf8_error());
            return Err(ControlsFileError::Io { file, error });
        }
    };
    match Bindings::from_ron(&text) {
        Ok(bindings) => Ok(ControlsFile { bindings, file, text }),
        Err(error) => Err(ControlsFileError::Text { file, error }),
    }
}

/// Loads [`ControlsFile`]; changes of the file reach the game when the asset server watches files.
#[derive(TypePath, Default)]
pub(crate) struct ControlsLoader;

impl AssetLoader for ControlsLoader {
    type Asset = ControlsFile;
    type Settings = ();
    type Error = ControlsFileError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        load_context: &mut LoadContext<'_>,
    ) -> Result<ControlsFile, ControlsFileError> {
        let file = load_context.path().to_string();
        let mut bytes = Vec::new();
        let read = reader.read_to_end(&mut bytes).await;
        read.map_err(|error| ControlsFileError::Io { file: file.clone(), error })?;
        parse(&file, bytes)
    }

    fn extensions(&self) -> &[&str] {
        &["controls.ron"]
    }
}
