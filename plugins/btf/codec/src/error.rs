//! What can be wrong with a material.

use std::path::{Path, PathBuf};

/// Why a material could not be read or made.
#[derive(Debug, thiserror::Error)]
pub enum BtfError {
    /// The file or folder can't be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// What was read.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file is not what its format says.
    #[error("{}: {what}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong, with the line or offset where it is known.
        what: String,
    },
    /// Tables that contradict each other, whatever they were read from.
    #[error("the material is damaged: {0}")]
    Tables(String),
    /// The material uses something that is not understood.
    #[error("not supported: {0}")]
    Unsupported(String),
}

impl BtfError {
    /// The same about bytes whose file is known.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        match self {
            Self::Tables(what) | Self::Unsupported(what) => Self::format(path, what),
            other => other,
        }
    }

    pub(crate) fn format(path: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self::Format { path: path.into(), what: what.into() }
    }

    pub(crate) fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), source }
    }
}
