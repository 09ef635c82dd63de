//! Blobs on their way to the server.

use std::collections::{BTreeMap, VecDeque};

use crate::{
    Blob, BlobHash, Limits, WireError,
    client::CHUNK_BYTES,
    message::{Chunk, MAX_WANTED},
};

/// What is wanted from the client, and what of it has come.
#[derive(Debug, Default)]
pub(super) struct Incoming {
    wanted: BTreeMap<BlobHash, Assembly>,
    /// To be asked for.
    to_ask: VecDeque<BlobHash>,
    /// Bytes of pieces that are kept.
    bytes: usize,
}

/// Pieces of a blob by offset. Memory is taken as they come, whatever the client says of the whole.
#[derive(Debug, Default)]
struct Assembly {
    total: u32,
    pieces: BTreeMap<u32, Vec<u8>>,
    bytes: usize,
}

impl Incoming {
    /// Asks for a blob unless that was done.
    pub(super) fn want(&mut self, hash: BlobHash) {
        if self.wanted.insert(hash, Assembly::default()).is_none() {
            self.to_ask.push_back(hash);
        }
    }

    /// It is not needed any more.
    pub(super) fn forget(&mut self, hash: &BlobHash) {
        if let Some(assembly) = self.wanted.remove(hash) {
            self.bytes -= assembly.bytes;
        }
    }

    /// A new connection: asks again, for what is missing.
    pub(super) fn ask_again(&mut self) {
        self.to_ask = self.wanted.keys().copied().collect();
    }

    /// Blobs to ask for now, each from the first missing byte on.
    pub(super) fn take_questions(&mut self) -> Option<Vec<(BlobHash, u32)>> {
        let mut questions = Vec::new();
        while questions.len() < MAX_WANTED
            && let Some(hash) = self.to_ask.pop_front()
        {
            if let Some(assembly) = self.wanted.get(&hash) {
                questions.push((hash, assembly.first_missing()));
            }
        }
        (!questions.is_empty()).then_some(questions)
    }

    /// A piece came; answers the blob if it was the last one.
    pub(super) fn receive(
        &mut self,
        chunk: Chunk,
        limits: &Limits,
    ) -> Result<Option<Blob>, WireError> {
        // An answer to a question that is no longer of interest.
        let Some(assembly) = self.wanted.get_mut(&chunk.hash) else { return Ok(None) };
        let Chunk { hash, total, offset, data } = chunk;
        WireError::check("bytes of a blob", total as usize, limits.blob_bytes)?;
        if assembly.total == 0 {
            assembly.total = total;
        }
        let in_place = (offset as usize).is_multiple_of(CHUNK_BYTES)
            && offset < total
            && data.len() == CHUNK_BYTES.min((total - offset) as usize);
        if total == 0 || assembly.total != total || !in_place {
            return Err(WireError::invalid("a piece of a blob", "its place makes no sense"));
        }
        if !assembly.pieces.contains_key(&offset) {
            assembly.bytes += data.len();
            self.bytes += data.len();
            WireError::check("bytes of blobs on their way", self.bytes, limits.session_blob_bytes)?;
            assembly.pieces.insert(offset, data);
        }
        if assembly.bytes < total as usize {
            return Ok(None);
        }
        let pieces: Vec<Vec<u8>> = std::mem::take(&mut assembly.pieces).into_values().collect();
        self.forget(&hash);
        Blob::decode(&pieces.concat(), hash, limits.blob_bytes).map(Some)
    }

    /// Whether everything that was wanted has come.
    pub(super) fn is_empty(&self) -> bool {
        self.wanted.is_empty()
    }
}

impl Assembly {
    fn first_missing(&self) -> u32 {
        let mut end = 0;
        for (offset, piece) in &self.pieces {
            if *offset != end {
                break;
            }
            end += piece.len() as u32;
        }
        end
    }
}
