//! Recordings of actions as files.

use std::path::Path;

use farlight::controls::bindings::Recording;

/// Largest recording that is read, in bytes.
const LARGEST: u64 = 64 << 20;

/// Reads a recording.
pub fn read(path: &Path) -> Result<Recording, String> {
    let fail = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let size = std::fs::metadata(path).map_err(|error| fail(&error))?.len();
    if size > LARGEST {
        return Err(fail(&"too large for a recording"));
    }
    let text = std::fs::read_to_string(path).map_err(|error| fail(&error))?;
    text.parse().map_err(|error| fail(&error))
}
