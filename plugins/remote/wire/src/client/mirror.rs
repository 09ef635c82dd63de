//! The client's scene: what the server should know, and what of it is not there yet.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap, VecDeque},
    sync::Arc,
};

use farlight_gi_solver::{
    SceneChange,
    scene::Sky,
    session::{SessionChange, SnapshotId},
};

use crate::{
    Blob, BlobHash,
    codec::Writer,
    message::{
        Object, ObjectKey, SkyObject, SnapshotPart, is_readable, total_probes, write_change,
    },
};

/// Snapshots that may be on their way. More are not sent: what changes meanwhile is collected.
const MAX_UNDER_WAY: usize = 8;
/// Bytes of a part after which the next begins.
const PART_BYTES: usize = 32 << 10;

/// The newest state of every object, and which the server lacks.
#[derive(Debug, Default)]
pub(super) struct Mirror {
    objects: BTreeMap<ObjectKey, Object>,
    blobs: HashMap<BlobHash, (Blob, usize)>,
    /// Changed since it was last sent.
    unsent: BTreeSet<ObjectKey>,
    /// Sent, and not acknowledged.
    under_way: VecDeque<(SnapshotId, Vec<ObjectKey>)>,
    newest: SnapshotId,
    acknowledged: SnapshotId,
    /// Something was submitted since a snapshot was last sent.
    news: bool,
}

impl Mirror {
    /// Takes changes over.
    pub(super) fn submit(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>) {
        self.newest = self.newest.max(snapshot);
        self.news = true;
        for change in changes {
            let (key, object) = self.object(change);
            // What the server would refuse, and end the connection for, does not exist for it.
            let readable = object.as_ref().is_none_or(|object| is_readable(&key, object));
            if !readable && let Some(hash) = object.as_ref().and_then(Object::blob) {
                self.release(hash);
            }
            self.set(key, object.filter(|_| readable));
        }
    }

    fn set(&mut self, key: ObjectKey, object: Option<Object>) {
        if self.objects.get(&key) == object.as_ref() {
            // A blob that was named again is counted once.
            if let Some(hash) = object.as_ref().and_then(Object::blob) {
                self.release(hash);
            }
            return;
        }
        let old = match object {
            Some(object) => self.objects.insert(key, object),
            None => self.objects.remove(&key),
        };
        if let Some(hash) = old.as_ref().and_then(Object::blob) {
            self.release(hash);
        }
        self.unsent.insert(key);
    }

    fn object(&mut self, change: SessionChange) -> (ObjectKey, Option<Object>) {
        let change = match change {
            SessionChange::Scene(change) => change,
            SessionChange::AddReceiver(id) => {
                return (ObjectKey::Receiver(id), Some(Object::Receiver));
            }
            SessionChange::RemoveReceiver(id) => return (ObjectKey::Receiver(id), None),
            SessionChange::SetGrid(id, grid) => {
                return (ObjectKey::Grid(id), Some(Object::Grid(grid)));
            }
            SessionChange::RemoveGrid(id) => return (ObjectKey::Grid(id), None),
        };
        match change {
            SceneChange::SetMesh(id, mesh) => {
                let key = ObjectKey::Mesh(id);
                let hash = self.retain(&key, Blob::Mesh(mesh));
                (key, hash.map(Object::Mesh))
            }
            SceneChange::RemoveMesh(id) => (ObjectKey::Mesh(id), None),
            SceneChange::SetTexture(id, texture) => {
                let key = ObjectKey::Texture(id);
                let hash = self.retain(&key, Blob::Texture(texture));
                (key, hash.map(Object::Texture))
            }
            SceneChange::RemoveTexture(id) => (ObjectKey::Texture(id), None),
            SceneChange::SetMaterial(id, material) => {
                (ObjectKey::Material(id), Some(Object::Material(material)))
            }
            SceneChange::RemoveMaterial(id) => (ObjectKey::Material(id), None),
            SceneChange::SetInstance(id, instance) => {
                (ObjectKey::Instance(id), Some(Object::Instance(instance)))
            }
            SceneChange::RemoveInstance(id) => (ObjectKey::Instance(id), None),
            SceneChange::SetLight(id, light) => (ObjectKey::Light(id), Some(Object::Light(light))),
            SceneChange::RemoveLight(id) => (ObjectKey::Light(id), None),
            SceneChange::SetSky(sky) => {
                let sky = match sky {
                    Sky::Constant(radiance) => Some(SkyObject::Constant(radiance)),
                    Sky::Image { image, rotation, scale } => self
                        .retain(&ObjectKey::Sky, Blob::Sky(image))
                        .map(|image| SkyObject::Image { image, rotation, scale }),
                };
                (ObjectKey::Sky, sky.map(Object::Sky))
            }
            SceneChange::SetDirectSky(direct) => {
                (ObjectKey::DirectSky, Some(Object::DirectSky(direct)))
            }
        }
    }

    /// Counts a blob that an object is going to name. What the object names already is not hashed
    /// again. `None`: no server takes it.
    fn retain(&mut self, key: &ObjectKey, blob: Blob) -> Option<BlobHash> {
        let named = self.objects.get(key).and_then(Object::blob);
        let named = named.filter(|hash| self.blobs.get(hash).is_some_and(|(b, _)| same(b, &blob)));
        let hash = named.or_else(|| blob.check().is_ok().then(|| blob.hash()))?;
        self.blobs.entry(hash).or_insert((blob, 0)).1 += 1;
        Some(hash)
    }

    fn release(&mut self, hash: BlobHash) {
        if let Some((_, users)) = self.blobs.get_mut(&hash) {
            *users -= 1;
            if *users == 0 {
                self.blobs.remove(&hash);
            }
        }
    }

    /// A blob that an object names.
    pub(super) fn blob(&self, hash: &BlobHash) -> Option<&Blob> {
        self.blobs.get(hash).map(|(blob, _)| blob)
    }

    /// What the server lacks, in parts, if there is something and little is on its way.
    pub(super) fn next_snapshot(&mut self) -> Option<Vec<SnapshotPart>> {
        if !self.news && self.unsent.is_empty() || self.under_way.len() >= MAX_UNDER_WAY {
            return None;
        }
        self.news = false;
        let keys: Vec<ObjectKey> = std::mem::take(&mut self.unsent).into_iter().collect();
        let snapshot = self.newest;
        let part = || SnapshotPart { snapshot, last: false, changes: Vec::new() };
        let (mut parts, mut bytes) = (vec![part()], 0);
        for key in &keys {
            let object = self.objects.get(key).cloned();
            let mut measure = Writer::default();
            write_change(&mut measure, key, object.as_ref());
            if bytes + measure.len() > PART_BYTES {
                parts.push(part());
                bytes = 0;
            }
            bytes += measure.len();
            if let Some(part) = parts.last_mut() {
                part.changes.push((*key, object));
            }
        }
        if let Some(part) = parts.last_mut() {
            part.last = true;
        }
        self.under_way.push_back((snapshot, keys));
        Some(parts)
    }

    /// The server has everything up to `snapshot`.
    pub(super) fn acknowledge(&mut self, snapshot: SnapshotId) {
        self.acknowledged = self.acknowledged.max(snapshot.min(self.newest));
        while self.under_way.front().is_some_and(|(sent, _)| *sent <= snapshot) {
            self.under_way.pop_front();
        }
    }

    /// A new connection to a server that has everything up to `snapshot`, or nothing.
    pub(super) fn reconnect(&mut self, snapshot: Option<SnapshotId>) {
        match snapshot {
            Some(snapshot) => {
                self.acknowledge(snapshot);
                for (_, keys) in self.under_way.drain(..) {
                    self.unsent.extend(keys);
                }
            }
            None => {
                self.under_way.clear();
                self.acknowledged = SnapshotId::default();
                self.unsent = self.objects.keys().copied().collect();
            }
        }
        self.news |= self.acknowledged < self.newest;
    }

    /// The newest snapshot that was submitted, and that the server has.
    pub(super) fn progress(&self) -> (SnapshotId, SnapshotId) {
        (self.newest, self.acknowledged)
    }

    /// Probes of all grids.
    pub(super) fn probes(&self) -> usize {
        total_probes(&self.objects)
    }

    pub(super) fn unsent(&self) -> usize {
        self.unsent.len()
    }

    /// Whether the server has it all.
    pub(super) fn in_sync(&self) -> bool {
        !self.news && self.unsent.is_empty() && self.under_way.is_empty()
    }
}

/// Whether two blobs are the same memory.
fn same(a: &Blob, b: &Blob) -> bool {
    match (a, b) {
        (Blob::Mesh(a), Blob::Mesh(b)) => Arc::ptr_eq(a, b),
        (Blob::Texture(a), Blob::Texture(b)) => Arc::ptr_eq(a, b),
        (Blob::Sky(a), Blob::Sky(b)) => Arc::ptr_eq(a, b),
        _ => false,
    }
}
