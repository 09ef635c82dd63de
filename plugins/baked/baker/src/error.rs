//! Why a bake failed.

use std::{io, path::PathBuf};

use farlight_gi_solver::import::ImportError;
use thiserror::Error;

use crate::{gltf::GltfError, lights::LightsError};

/// Why a bake failed. An earlier result stays as it was.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BakeError {
    /// An option is out of its range.
    #[error("{option}: {problem}")]
    Option {
        /// The field of [`BakeOptions`](crate::BakeOptions).
        option: &'static str,
        /// What is wrong.
        problem: String,
    },
    /// The scene can't be read.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The lit scene can't be written.
    #[error("{file}: {problem}")]
    Gltf {
        /// The scene's file.
        file: String,
        /// What is wrong.
        problem: GltfError,
    },
    /// The file of lights can't be used.
    #[error(transparent)]
    Lights(#[from] LightsError),
    /// No primitive can get a lightmap.
    #[error("{file}: nothing to light: {why}")]
    NothingToLight {
        /// The scene's file.
        file: String,
        /// Why.
        why: String,
    },
    /// A file or folder of the results can't be used.
    #[error("{}: can't be {doing}: {source}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// What was tried, as a participle.
        doing: &'static str,
        /// Why not.
        source: io::Error,
    },
    /// Something of that name is there and was not made by a bake.
    #[error("{}: {what}", path.display())]
    Foreign {
        /// Which.
        path: PathBuf,
        /// What it is, and what to do.
        what: String,
    },
    /// Another bake into the same folder goes on.
    #[error("{}: another bake (process {process}) writes into this folder", folder.display())]
    Locked {
        /// The folder.
        folder: PathBuf,
        /// Its process id, if it could be read.
        process: String,
    },
    /// It was stopped before there was anything to write. What was computed is kept for the next run.
    #[error("stopped before there was any light to write; the next run goes on from here")]
    Stopped,
    /// The inputs changed meanwhile.
    #[error("the scene changed meanwhile")]
    Outdated,
}
