//! Blobs on their way to the server.

use std::collections::{BTreeMap, VecDeque, btree_map::Entry};

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
        // What has come of it already is kept when a second object names it.
        if let Entry::Vacant(place) = self.wanted.entry(hash) {
            place.insert(Assembly::default());
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use farlight_gi_solver::scene::Texture;

    use super::*;

    #[test]
    fn what_is_wanted_twice_keeps_its_pieces() {
        // Noise, so that it is long.
        let texels = (0..40_000_u32).map(|i| i.wrapping_mul(2_654_435_761).rotate_left(i % 31));
        let texels = texels.map(u32::to_le_bytes).collect();
        let texture = Texture { width: 200, height: 200, texels, srgb: false };
        let blob = Blob::Texture(Arc::new(texture));
        let (hash, bytes) = (blob.hash(), blob.encode());
        assert!(bytes.len() > 2 * CHUNK_BYTES);
        let limits = Limits::default();
        let mut incoming = Incoming::default();
        let mut arrived = None;
        for (i, piece) in bytes.chunks(CHUNK_BYTES).enumerate() {
            incoming.want(hash);
            let offset = (i * CHUNK_BYTES) as u32;
            let chunk = Chunk { hash, total: bytes.len() as u32, offset, data: piece.to_vec() };
            arrived = incoming.receive(chunk, &limits).unwrap();
        }
        assert_eq!(arrived.map(|blob| blob.hash()), Some(hash));
        assert!(incoming.is_empty() && incoming.bytes == 0);
    }
}
