//! Errors that say which file, where in it, and what to do.

use std::{fmt, path::Path};

/// One line for the user.
#[derive(Debug)]
pub(crate) struct CliError(String);

impl CliError {
    /// A message about the whole run.
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }

    /// A problem with a file; `place` is a line, a line and a column, or a field.
    pub(crate) fn in_file(path: &Path, place: impl fmt::Display, what: impl fmt::Display) -> Self {
        Self(format!("{}:{place}: {what}", path.display()))
    }

    /// A problem with a file that says itself where in it.
    pub(crate) fn beside(path: &Path, what: impl fmt::Display) -> Self {
        Self(format!("{}:{what}", path.display()))
    }

    /// A file that can't be read or written.
    pub(crate) fn io(path: &Path, doing: &str, error: &std::io::Error) -> Self {
        Self(format!("{}: can't be {doing}: {error}", path.display()))
    }
}

impl fmt::Display for CliError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl From<farlight_gi_solver::import::ImportError> for CliError {
    fn from(error: farlight_gi_solver::import::ImportError) -> Self {
        Self(error.to_string())
    }
}

impl From<farlight_btf_codec::BtfError> for CliError {
    fn from(error: farlight_btf_codec::BtfError) -> Self {
        Self(error.to_string())
    }
}

impl From<farlight_environment::EnvironmentError> for CliError {
    fn from(error: farlight_environment::EnvironmentError) -> Self {
        Self(error.to_string())
    }
}

/// The text of a file.
pub(crate) fn read_text(path: &Path) -> Result<String, CliError> {
    let bytes = std::fs::read(path).map_err(|e| CliError::io(path, "read", &e))?;
    String::from_utf8(bytes).map_err(|e| {
        let good = e.utf8_error().valid_up_to();
        let line = 1 + e.as_bytes()[..good].iter().filter(|b| **b == b'\n').count();
        CliError::in_file(path, line, "not UTF-8 text")
    })
}
