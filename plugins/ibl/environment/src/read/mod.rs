//! Readers of files. Each hands a picture's rows on as it decodes them, so that none is held whole.

mod radiance;

use crate::{Environment, EnvironmentError, Layout};

/// Reads what the first bytes say.
pub(crate) fn read(bytes: &[u8], layout: Layout) -> Result<Environment, EnvironmentError> {
    if bytes.starts_with(b"#?") {
        radiance::read(bytes, layout)
    } else {
        Err(EnvironmentError::Unknown)
    }
}
