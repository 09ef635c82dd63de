//! What can be wrong with an environment map.

use std::path::{Path, PathBuf};

/// Why a map could not be read or made.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentError {
    /// The file can't be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// What was read.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Something about a file; see the inner error.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<Self>,
    },
    /// The bytes are not what their format says.
    #[error("not a {format} picture that can be read: {what}")]
    Format {
        /// Name of the format.
        format: &'static str,
        /// What is wrong.
        what: String,
    },
    /// The bytes begin like none of the formats that are read.
    #[error(
        "of no known format: environment maps are Radiance (.hdr), OpenEXR (.exr), KTX2 (.ktx2), \
         PNG or JPEG files"
    )]
    Unknown,
    /// A format's variant that is not understood; says what to convert it to.
    #[error("not supported: {0}")]
    Unsupported(String),
    /// Width and height don't fit the layout or the number of texels, or are too large.
    #[error("{0}")]
    Size(String),
}

impl EnvironmentError {
    pub(crate) fn format(format: &'static str, what: impl Into<String>) -> Self {
        Self::Format { format, what: what.into() }
    }

    /// The same about a file.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        Self::File { path: path.to_owned(), source: Box::new(self) }
    }
}
