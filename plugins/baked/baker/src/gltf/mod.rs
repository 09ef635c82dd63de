//! glTF in, glTF out.
//!
//! [`Source`] holds a `.glb` or `.gltf` file with everything that belongs to it; [`write()`] writes it
//! as one self-contained `.glb` with new second UV sets, in metres, with marked nodes. Everything
//! that this module does not know stays as it was.

mod elements;
mod images;
mod nodes;
mod primitives;
mod references;
mod source;
pub(crate) mod values;
mod write;

use thiserror::Error;

pub use source::Source;
pub use write::write;

/// Why the lit scene could not be written.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum GltfError {
    /// A part of the file can't be read or does not fit the rest.
    #[error("{place}: {what}; the file is damaged or its exporter has a bug, export it again")]
    Damaged {
        /// Where, as in the JSON: `meshes[3].primitives[0]`.
        place: String,
        /// What is wrong there.
        what: String,
    },
    /// The result does not fit a .glb file, whose lengths have 32 bits.
    #[error("the lit scene would have {bytes} bytes, a .glb file ends at 4 GiB: split the scene")]
    TooLarge {
        /// How many it would have.
        bytes: u64,
    },
    /// The scale is no positive number.
    #[error("a scale of {0} metres a unit is not possible")]
    Scale(String),
}
