//! The words of a material, in memory or in a file that is read in place.

use std::sync::Arc;

use memmap2::Mmap;

/// 32-bit words.
#[derive(Clone)]
pub(crate) enum Words {
    Owned(Vec<u32>),
    /// A part of a mapped file that begins at a multiple of 4 bytes.
    Mapped {
        map: Arc<Mmap>,
        from: usize,
    },
}

impl Words {
    /// From little-endian bytes, however they lie in memory.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Self {
        Self::Owned(bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
    }

    /// The words of a mapped file from byte `from` to its end.
    pub(crate) fn mapped(map: Arc<Mmap>, from: usize) -> Self {
        let bytes = map.get(from..).unwrap_or_default();
        if cfg!(target_endian = "little") && bytemuck::try_cast_slice::<u8, u32>(bytes).is_ok() {
            Self::Mapped { map, from }
        } else {
            Self::from_bytes(bytes)
        }
    }

    pub(crate) fn as_slice(&self) -> &[u32] {
        match self {
            Self::Owned(words) => words,
            // Neither can fail: it was tried when the map was made, and maps do not move.
            Self::Mapped { map, from } => {
                bytemuck::try_cast_slice(map.get(*from..).unwrap_or_default()).unwrap_or_default()
            }
        }
    }
}

impl std::fmt::Debug for Words {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kind = match self {
            Self::Owned(_) => "in memory",
            Self::Mapped { .. } => "mapped",
        };
        write!(f, "{} words, {kind}", self.as_slice().len())
    }
}
