//! Readers of files. Those of large pictures hand rows on as they decode them, so that no picture is
//! held whole.

mod ktx;
mod openexr;
mod radiance;
mod screen;
mod transfer;

use image::ImageFormat;

use crate::{Environment, EnvironmentError, Layout};

/// Reads what the first bytes say.
pub(crate) fn read(bytes: &[u8], layout: Layout) -> Result<Environment, EnvironmentError> {
    if bytes.starts_with(b"#?") {
        radiance::read(bytes, layout)
    } else if bytes.starts_with(&openexr::MAGIC) {
        openexr::read(bytes, layout)
    } else if bytes.starts_with(&ktx::MAGIC) {
        ktx::read(bytes, layout)
    } else if bytes.starts_with(b"\x89PNG") {
        screen::read(bytes, ImageFormat::Png, layout)
    } else if bytes.starts_with(b"\xff\xd8\xff") {
        screen::read(bytes, ImageFormat::Jpeg, layout)
    } else {
        Err(EnvironmentError::Unknown)
    }
}
