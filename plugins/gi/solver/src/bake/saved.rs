//! Gathered light as bytes, so that a bake can be taken up again.

use glam::Vec3;
use thiserror::Error;

use super::{Gathered, Layout};

/// The first bytes; the last of them is the version.
const MAGIC: [u8; 8] = *b"FLgather";
const VERSION: u32 = 1;
/// Magic, version, rays, texels, checksum.
const HEADER: usize = 8 + 4 + 4 + 8 + 8;

/// Why bytes are not gathered light of a layout.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum SavedError {
    /// They do not begin as they should.
    #[error("not gathered light")]
    Foreign,
    /// Another version wrote them.
    #[error("gathered light of version {0}, this is version {VERSION}")]
    Version(u32),
    /// They belong to a layout with other texels.
    #[error("gathered light of {found} texels, the layout has {expected}")]
    Texels {
        /// Texels of the bytes.
        found: u64,
        /// Texels of the layout.
        expected: u64,
    },
    /// They are cut off, too long, or were changed.
    #[error("gathered light is damaged")]
    Damaged,
}

impl Gathered {
    /// All of it: 24 bytes a texel. Little-endian everywhere.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let texels = self.halves[0].len();
        let mut sums = Vec::with_capacity(texels * 24);
        for sum in self.halves.iter().flatten().flat_map(|v| v.to_array()) {
            sums.extend(sum.to_le_bytes());
        }
        let mut bytes = Vec::with_capacity(HEADER + sums.len());
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(self.rays.to_le_bytes());
        bytes.extend((texels as u64).to_le_bytes());
        bytes.extend(checksum(self.rays, &sums).to_le_bytes());
        bytes.extend(sums);
        bytes
    }

    /// Undoes [`to_bytes`](Self::to_bytes). That they belong to the same scene, layout and settings is
    /// for the caller to know; here only the number of texels is checked.
    ///
    /// # Errors
    /// [`SavedError`]; memory is taken only for what the layout needs.
    pub fn from_bytes(layout: &Layout, bytes: &[u8]) -> Result<Self, SavedError> {
        let (header, sums) = bytes.split_at_checked(HEADER).ok_or(SavedError::Foreign)?;
        let word = |at: usize| u32::from_le_bytes(header[at..at + 4].try_into().unwrap_or([0; 4]));
        let long = |at: usize| u64::from(word(at)) | u64::from(word(at + 4)) << 32;
        if header[..8] != MAGIC {
            return Err(SavedError::Foreign);
        }
        if word(8) != VERSION {
            return Err(SavedError::Version(word(8)));
        }
        let (rays, found, expected) = (word(12), long(16), layout.len() as u64);
        if found != expected {
            return Err(SavedError::Texels { found, expected });
        }
        let half = layout.len() * 12;
        if sums.len() != half * 2 || checksum(rays, sums) != long(24) {
            return Err(SavedError::Damaged);
        }
        let read = |bytes: &[u8]| -> Vec<Vec3> {
            let float = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
            let vector = |b: &[u8]| Vec3::new(float(b), float(&b[4..]), float(&b[8..]));
            bytes.chunks_exact(12).map(vector).collect()
        };
        let (first, second) = sums.split_at(half);
        Ok(Self { rays, halves: [read(first), read(second)] })
    }
}

/// FNV-1a over words of eight bytes: finds accidents, not attacks.
fn checksum(rays: u32, bytes: &[u8]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64 ^ u64::from(rays);
    for chunk in bytes.chunks(8) {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        hash = (hash ^ u64::from_le_bytes(word)).wrapping_mul(0x0000_0100_0000_01b3);
        hash ^= hash >> 29;
    }
    hash
}
