//! The file with the invitation.

use std::{
    fs::{self, OpenOptions},
    io::{self, Write as _},
    path::{Path, PathBuf},
};

use farlight_wire::Invitation;

use crate::error::CliError;

/// A file that holds the invitation for as long as the server runs.
pub(super) struct InviteFile {
    path: PathBuf,
    text: String,
}

impl InviteFile {
    /// Writes it whole or not at all: into a file beside it that is then renamed. On Unix only its
    /// owner can read it.
    pub(super) fn write(path: &Path, invitation: &Invitation) -> Result<Self, CliError> {
        let file = Self { path: path.to_owned(), text: format!("{invitation}\n") };
        let Some(name) = path.file_name() else {
            return Err(CliError::new(format!("{}: is not a file name", path.display())));
        };
        let mut part = name.to_owned();
        part.push(format!(".part{}", std::process::id()));
        let part = path.with_file_name(part);
        let written = write_private(&part, &file.text).and_then(|()| fs::rename(&part, path));
        written.map_err(|error| {
            // Best effort: the error that matters is the first one.
            let _ = fs::remove_file(&part);
            CliError::io(path, "written", &error)
        })?;
        Ok(file)
    }

    /// Removes it, unless another server has written its own there.
    pub(super) fn remove(self) {
        if fs::read_to_string(&self.path).is_ok_and(|text| text == self.text)
            && let Err(error) = fs::remove_file(&self.path)
        {
            tracing::warn!("{}: can't be removed: {error}", self.path.display());
        }
    }
}

fn write_private(path: &Path, text: &str) -> io::Result<()> {
    // What a process with this number has left behind is in the way.
    let _ = fs::remove_file(path);
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let mut file = options.open(path)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()
}
