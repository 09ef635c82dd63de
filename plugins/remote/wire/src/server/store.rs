//! Decoded blobs by content, shared by sessions.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use crate::{Blob, BlobHash};

/// Decoded meshes and images by content, shared by the sessions of a server, with a bound. What no
/// session uses goes first, oldest first. It locks itself for moments only: blobs are decoded
/// outside of it, so sessions don't wait for each other.
#[derive(Debug, Default)]
pub struct BlobStore {
    shelves: Mutex<Shelves>,
    unused_bytes: usize,
}

#[derive(Debug, Default)]
struct Shelves {
    blobs: HashMap<BlobHash, Entry>,
    clock: u64,
}

#[derive(Debug)]
struct Entry {
    blob: Blob,
    last_used: u64,
}

impl BlobStore {
    /// A store that keeps at most so many bytes beyond what sessions use.
    #[must_use]
    pub fn new(unused_bytes: usize) -> Self {
        Self { unused_bytes, ..Self::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Shelves> {
        // Every change of the shelves is one call that can't be left halfway.
        self.shelves.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Bytes of all that it holds.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.lock().blobs.values().map(|entry| entry.blob.memory()).sum()
    }

    pub(super) fn get(&self, hash: &BlobHash) -> Option<Blob> {
        let mut shelves = self.lock();
        shelves.clock += 1;
        let now = shelves.clock;
        let entry = shelves.blobs.get_mut(hash)?;
        entry.last_used = now;
        Some(entry.blob.clone())
    }

    pub(super) fn insert(&self, hash: BlobHash, blob: Blob) {
        let mut shelves = self.lock();
        shelves.clock += 1;
        let last_used = shelves.clock;
        shelves.blobs.insert(hash, Entry { blob, last_used });
        drop(shelves);
        self.trim();
    }

    /// Lets go of what no session uses, down to the bound. Sessions end without telling the store,
    /// so it is also called when one has ended.
    pub fn trim(&self) {
        let mut shelves = self.lock();
        let mut unused: Vec<(u64, BlobHash, usize)> = shelves
            .blobs
            .iter()
            .filter(|(_, entry)| is_unused(&entry.blob))
            .map(|(hash, entry)| (entry.last_used, *hash, entry.blob.memory()))
            .collect();
        let mut bytes: usize = unused.iter().map(|(.., bytes)| bytes).sum();
        unused.sort_unstable_by_key(|(last_used, ..)| *last_used);
        for (_, hash, size) in unused {
            if bytes <= self.unused_bytes {
                return;
            }
            shelves.blobs.remove(&hash);
            bytes -= size;
        }
    }
}

/// Whether only the store holds it.
fn is_unused(blob: &Blob) -> bool {
    match blob {
        Blob::Mesh(mesh) => Arc::strong_count(mesh) == 1,
        Blob::Texture(texture) => Arc::strong_count(texture) == 1,
        Blob::Sky(image) => Arc::strong_count(image) == 1,
    }
}

#[cfg(test)]
mod tests {
    use farlight_gi_solver::scene::Texture;

    use super::*;

    #[test]
    fn what_is_used_stays_and_the_oldest_of_the_rest_goes() {
        let blob = |value| {
            let texels = vec![[value; 4]; 256];
            Blob::Texture(Arc::new(Texture { width: 16, height: 16, texels, srgb: true }))
        };
        let size = blob(0).memory();
        let store = BlobStore::new(2 * size);
        let used = blob(0);
        store.insert(BlobHash([0; 32]), used.clone());
        for i in 1..=4 {
            store.insert(BlobHash([i; 32]), blob(i));
            if i == 2 {
                assert!(store.get(&BlobHash([1; 32])).is_some(), "makes it newer than 2");
            }
        }
        let mut there = (0..=4).filter(|i| store.get(&BlobHash([*i; 32])).is_some());
        assert_eq!(there.by_ref().collect::<Vec<_>>(), [0, 3, 4]);
        drop(used);
        store.trim();
        assert_eq!(store.bytes(), 2 * size);
    }
}
