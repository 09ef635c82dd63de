//! Readers of material files.

mod archive;
mod binary;
mod description;
mod folder;
mod open;
mod text;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::BtfError;

pub use archive::read_archive;
pub use binary::read_binary;
pub(crate) use binary::{binary_from_bytes, is_binary};
pub use folder::read_folder;
pub use open::{Material, open};
pub use text::read_text;

/// How to read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// What to do about entries that a writer is known to have stored wrongly.
    pub repairs: Repairs,
    /// The material's name, where there are several.
    pub material: Option<String>,
}

/// What to do about entries that a writer is known to have stored wrongly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Repairs {
    /// Put them right as far as the data tells, and list them in
    /// [`Info::repairs`](crate::Info::repairs).
    #[default]
    Yes,
    /// Take everything as it is stored.
    No,
}

/// The longest file that is read into memory: a gibibyte.
const LONGEST_FILE: u64 = 1 << 30;

/// Degrees from the normal of the lowest lights of the measurements that BTFbase sets were made from
/// (81 directions in rings of 15 degrees).
const LIGHT_LIMIT: f32 = 75.0;

/// A whole file, if it is not too long.
fn read_bounded(path: &Path) -> Result<Vec<u8>, BtfError> {
    let io = |error| BtfError::io(path, error);
    let file = File::open(path).map_err(io)?;
    let length = file.metadata().map_err(io)?.len();
    let mut bytes = Vec::with_capacity(length.min(LONGEST_FILE) as usize);
    // One more, so that a file that grows is noticed too.
    file.take(LONGEST_FILE + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > LONGEST_FILE {
        return Err(BtfError::format(path, format!("longer than {LONGEST_FILE} bytes")));
    }
    Ok(bytes)
}
