//! Heavy data by content: meshes, textures and sky images.

use std::sync::Arc;

use farlight_gi_solver::scene::{Mesh, SkyImage, Texture};

use crate::WireError;

/// BLAKE3 hash of a blob's encoding before compression.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BlobHash(pub [u8; 32]);

/// Heavy data, shared.
#[derive(Clone, Debug)]
pub enum Blob {
    /// Triangles.
    Mesh(Arc<Mesh>),
    /// An image of a material.
    Texture(Arc<Texture>),
    /// An image of the sky.
    Sky(Arc<SkyImage>),
}

impl Blob {
    /// Names it.
    #[must_use]
    pub fn hash(&self) -> BlobHash {
        todo!()
    }

    /// Its encoding, compressed: what travels, in chunks.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        todo!()
    }

    /// Back from [`encode`](Self::encode).
    ///
    /// # Errors
    /// It is not an encoding, has another hash than `expected`, or would take more than `limit`
    /// bytes of memory.
    pub fn decode(_bytes: &[u8], _expected: BlobHash, _limit: usize) -> Result<Self, WireError> {
        todo!()
    }

    /// Bytes of memory that it takes.
    #[must_use]
    pub fn memory(&self) -> usize {
        todo!()
    }
}
