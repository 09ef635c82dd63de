//! Blobs on their way to the server, in chunks.

use std::collections::{HashSet, VecDeque};

use super::mirror::Mirror;
use crate::{
    BlobHash, TransmitId,
    message::{Chunk, ClientMessage},
};

/// Bytes of a chunk.
pub(crate) const CHUNK_BYTES: usize = 64 << 10;
/// Chunks that the network may hold: enough to keep it busy, few enough that other messages and
/// memory don't suffer.
const MAX_UNDER_WAY: usize = 8;

/// What the server asked for.
#[derive(Debug, Default)]
pub(super) struct Outgoing {
    wanted: VecDeque<(BlobHash, u32)>,
    current: Option<Sending>,
    under_way: HashSet<TransmitId>,
}

#[derive(Debug)]
struct Sending {
    hash: BlobHash,
    bytes: Vec<u8>,
    next: usize,
}

impl Outgoing {
    /// The server wants a blob, from an offset on.
    pub(super) fn want(&mut self, hash: BlobHash, offset: u32) {
        let known = self.wanted.iter().any(|(wanted, _)| *wanted == hash)
            || self.current.as_ref().is_some_and(|sending| sending.hash == hash);
        if !known {
            self.wanted.push_back((hash, offset));
        }
    }

    /// The connection is gone: the server will ask again.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// The next chunk, or word that the blob is gone.
    pub(super) fn next(&mut self, mirror: &Mirror) -> Option<ClientMessage> {
        if self.under_way.len() >= MAX_UNDER_WAY {
            return None;
        }
        if self.current.is_none() {
            let (hash, offset) = self.wanted.pop_front()?;
            let Some(blob) = mirror.blob(&hash) else { return Some(ClientMessage::Gone(hash)) };
            let bytes = blob.encode();
            // An offset that makes no sense: everything.
            let next = Some(offset as usize).filter(|o| *o < bytes.len()).unwrap_or(0);
            self.current = Some(Sending { hash, bytes, next });
        }
        let sending = self.current.as_mut()?;
        let end = (sending.next + CHUNK_BYTES).min(sending.bytes.len());
        let chunk = Chunk {
            hash: sending.hash,
            total: sending.bytes.len() as u32,
            offset: sending.next as u32,
            data: sending.bytes[sending.next..end].to_vec(),
        };
        sending.next = end;
        if end == sending.bytes.len() {
            self.current = None;
        }
        Some(ClientMessage::Chunk(chunk))
    }

    pub(super) fn transmitted(&mut self, id: TransmitId) {
        self.under_way.insert(id);
    }

    pub(super) fn sent(&mut self, id: TransmitId) {
        self.under_way.remove(&id);
    }

    /// Bytes that have not left, those of blobs that wait as they lie in memory.
    pub(super) fn unsent_bytes(&self, mirror: &Mirror) -> u64 {
        let current = self.current.as_ref().map_or(0, |s| s.bytes.len() - s.next);
        let waiting = self.wanted.iter().filter_map(|(hash, _)| mirror.blob(hash));
        waiting.map(|blob| blob.memory() as u64).sum::<u64>() + current as u64
    }

    pub(super) fn is_empty(&self) -> bool {
        self.wanted.is_empty() && self.current.is_none() && self.under_way.is_empty()
    }
}
