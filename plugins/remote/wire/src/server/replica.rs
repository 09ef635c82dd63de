//! The server's copy of the client's scene.
//!
//! What needs a blob that is still on its way waits: a mesh keeps its old triangles, an instance of
//! a mesh without triangles is held back together with its lightmap. Everything else goes on, so a
//! large mesh that is being sent doesn't stop the light.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap, VecDeque},
    time::Duration,
};

use farlight_gi_solver::{
    SceneChange,
    scene::{DirectSky, Instance, InstanceId, MeshId, Sky},
    session::{SessionChange, SnapshotId},
};

use super::{BlobStore, incoming::Incoming};
use crate::{
    Blob, BlobHash, Limits, WireError,
    message::{Chunk, Object, ObjectKey, SkyObject, SnapshotPart, total_probes},
};

/// Arrival times that are remembered.
const MAX_TIMES: usize = 256;

#[derive(Debug, Default)]
pub(super) struct Replica {
    objects: BTreeMap<ObjectKey, Object>,
    /// Blobs that objects name and that are here, with the number of objects.
    blobs: HashMap<BlobHash, (Blob, usize)>,
    /// Objects that wait for a blob.
    waiting: HashMap<BlobHash, BTreeSet<ObjectKey>>,
    /// Meshes whose triangles the solver has.
    solid: BTreeMap<MeshId, usize>,
    /// Instances that wait for their mesh.
    held: BTreeMap<InstanceId, Instance>,
    pub(super) incoming: Incoming,
    /// Parts of a snapshot whose last one has not come.
    parts: Vec<(ObjectKey, Option<Object>)>,
    snapshot: SnapshotId,
    times: VecDeque<(SnapshotId, Duration)>,
    /// For the solver.
    changes: Vec<SessionChange>,
    /// Something was completed since changes were last taken.
    news: bool,
}

impl Replica {
    /// A part of a snapshot came; answers whether it was the last.
    pub(super) fn receive(
        &mut self,
        now: Duration,
        part: SnapshotPart,
        limits: &Limits,
        store: &BlobStore,
    ) -> Result<bool, WireError> {
        if part.snapshot <= self.snapshot {
            return Err(WireError::Unexpected(format!(
                "snapshot {} after {}",
                part.snapshot.0, self.snapshot.0
            )));
        }
        WireError::check(
            "objects of a snapshot",
            self.parts.len() + part.changes.len(),
            limits.objects.saturating_mul(2),
        )?;
        self.parts.extend(part.changes);
        if !part.last {
            return Ok(false);
        }
        let changes = std::mem::take(&mut self.parts);
        let geometry = changes
            .iter()
            .any(|(key, _)| matches!(key, ObjectKey::Instance(_) | ObjectKey::Mesh(_)));
        let grids = changes.iter().any(|(key, _)| matches!(key, ObjectKey::Grid(_)));
        for (key, object) in changes {
            self.set(key, object, store)?;
        }
        self.release_held();
        self.check(limits, geometry, grids)?;
        self.snapshot = part.snapshot;
        self.news = true;
        if self.times.len() == MAX_TIMES {
            self.times.pop_front();
        }
        self.times.push_back((part.snapshot, now));
        Ok(true)
    }

    /// A new connection: parts of an unfinished snapshot are sent again.
    pub(super) fn reconnect(&mut self) {
        self.parts.clear();
        self.incoming.ask_again();
    }

    /// The newest complete snapshot.
    pub(super) fn snapshot(&self) -> SnapshotId {
        self.snapshot
    }

    /// How long ago a snapshot came; forgets it and older ones.
    pub(super) fn held(&mut self, now: Duration, snapshot: SnapshotId) -> Option<Duration> {
        let mut held = None;
        while let Some((id, arrived)) = self.times.front()
            && *id <= snapshot
        {
            held = (*id == snapshot).then(|| now.saturating_sub(*arrived));
            self.times.pop_front();
        }
        held
    }

    /// What the solver has not been given.
    pub(super) fn take_changes(&mut self) -> Option<(SnapshotId, Vec<SessionChange>)> {
        std::mem::take(&mut self.news).then(|| (self.snapshot, std::mem::take(&mut self.changes)))
    }

    /// Whether [`take_changes`](Self::take_changes) has something.
    pub(super) fn has_news(&self) -> bool {
        self.news
    }

    /// A piece of a blob came.
    pub(super) fn chunk(
        &mut self,
        chunk: Chunk,
        limits: &Limits,
        store: &BlobStore,
    ) -> Result<(), WireError> {
        let hash = chunk.hash;
        if let Some(blob) = self.incoming.receive(chunk, limits)? {
            store.insert(hash, blob.clone());
            self.arrived(hash, &blob)?;
            self.release_held();
            self.check(limits, true, false)?;
            self.news = true;
        }
        Ok(())
    }

    /// The client has no such blob any more.
    pub(super) fn gone(&mut self, hash: BlobHash) {
        self.incoming.forget(&hash);
        self.waiting.remove(&hash);
    }

    fn arrived(&mut self, hash: BlobHash, blob: &Blob) -> Result<(), WireError> {
        let keys = self.waiting.remove(&hash).unwrap_or_default();
        if keys.is_empty() {
            return Ok(());
        }
        self.blobs.insert(hash, (blob.clone(), keys.len()));
        for key in keys {
            self.resolve(key, blob)?;
        }
        Ok(())
    }

    /// Hands an object whose blob is here to the solver.
    fn resolve(&mut self, key: ObjectKey, blob: &Blob) -> Result<(), WireError> {
        let change = match (key, blob, self.objects.get(&key)) {
            (ObjectKey::Mesh(id), Blob::Mesh(mesh), _) => {
                self.solid.insert(id, mesh.triangles.len());
                SceneChange::SetMesh(id, mesh.clone())
            }
            (ObjectKey::Texture(id), Blob::Texture(texture), _) => {
                SceneChange::SetTexture(id, texture.clone())
            }
            (
                ObjectKey::Sky,
                Blob::Sky(image),
                Some(Object::Sky(SkyObject::Image { rotation, scale, .. })),
            ) => SceneChange::SetSky(Sky::Image {
                image: image.clone(),
                rotation: *rotation,
                scale: *scale,
            }),
            _ => return Err(WireError::invalid("a blob", "it is of another kind than its object")),
        };
        self.changes.push(SessionChange::Scene(change));
        Ok(())
    }

    fn set(
        &mut self,
        key: ObjectKey,
        object: Option<Object>,
        store: &BlobStore,
    ) -> Result<(), WireError> {
        let new = object.as_ref().and_then(Object::blob);
        let old = match &object {
            Some(object) => self.objects.insert(key, object.clone()),
            None => self.objects.remove(&key),
        };
        // The new one first, so that what both name stays.
        let blob = new.and_then(|hash| self.name(key, hash, store));
        if let Some(hash) = old.as_ref().and_then(Object::blob) {
            self.unname(key, hash, new == Some(hash));
        }
        if let Some(blob) = blob {
            return self.resolve(key, &blob);
        }
        if new.is_some() {
            return Ok(());
        }
        let scene = |change| Some(SessionChange::Scene(change));
        let change = match (key, object) {
            (ObjectKey::Texture(id), _) => scene(SceneChange::RemoveTexture(id)),
            (ObjectKey::Mesh(id), _) => {
                self.solid.remove(&id);
                scene(SceneChange::RemoveMesh(id))
            }
            (ObjectKey::Material(id), Some(Object::Material(material))) => {
                scene(SceneChange::SetMaterial(id, material))
            }
            (ObjectKey::Material(id), _) => scene(SceneChange::RemoveMaterial(id)),
            (ObjectKey::Instance(id), Some(Object::Instance(instance))) => {
                self.held.insert(id, instance);
                None
            }
            (ObjectKey::Instance(id), _) => {
                self.held.remove(&id);
                scene(SceneChange::RemoveInstance(id))
            }
            (ObjectKey::Receiver(id), Some(_)) => {
                // With its instance, if that is held back.
                (!self.held.contains_key(&id)).then_some(SessionChange::AddReceiver(id))
            }
            (ObjectKey::Receiver(id), None) => Some(SessionChange::RemoveReceiver(id)),
            (ObjectKey::Light(id), Some(Object::Light(light))) => {
                scene(SceneChange::SetLight(id, light))
            }
            (ObjectKey::Light(id), _) => scene(SceneChange::RemoveLight(id)),
            (ObjectKey::Sky, Some(Object::Sky(SkyObject::Constant(radiance)))) => {
                scene(SceneChange::SetSky(Sky::Constant(radiance)))
            }
            (ObjectKey::Sky, _) => scene(SceneChange::SetSky(Sky::default())),
            (ObjectKey::DirectSky, Some(Object::DirectSky(direct))) => {
                scene(SceneChange::SetDirectSky(direct))
            }
            (ObjectKey::DirectSky, _) => scene(SceneChange::SetDirectSky(DirectSky::default())),
            (ObjectKey::Grid(id), Some(Object::Grid(grid))) => {
                Some(SessionChange::SetGrid(id, grid))
            }
            (ObjectKey::Grid(id), _) => Some(SessionChange::RemoveGrid(id)),
        };
        self.changes.extend(change);
        Ok(())
    }

    /// An object names a blob; answers the blob if it is here, else asks for it.
    fn name(&mut self, key: ObjectKey, hash: BlobHash, store: &BlobStore) -> Option<Blob> {
        if let Some((blob, users)) = self.blobs.get_mut(&hash) {
            *users += 1;
            return Some(blob.clone());
        }
        if !self.waiting.contains_key(&hash)
            && let Some(blob) = store.get(&hash)
        {
            self.blobs.insert(hash, (blob.clone(), 1));
            return Some(blob);
        }
        self.waiting.entry(hash).or_default().insert(key);
        self.incoming.want(hash);
        None
    }

    /// An object no longer names a blob, or does so once more than it should (`again`).
    fn unname(&mut self, key: ObjectKey, hash: BlobHash, again: bool) {
        if let Some((_, users)) = self.blobs.get_mut(&hash) {
            *users -= 1;
            if *users == 0 {
                self.blobs.remove(&hash);
            }
        } else if !again && let Some(keys) = self.waiting.get_mut(&hash) {
            keys.remove(&key);
            if keys.is_empty() {
                self.waiting.remove(&hash);
                self.incoming.forget(&hash);
            }
        }
    }

    /// Lets instances go whose mesh is there, or is not to be expected.
    fn release_held(&mut self) {
        let free: Vec<InstanceId> = self
            .held
            .iter()
            .filter(|(_, instance)| {
                self.solid.contains_key(&instance.mesh)
                    || !self.objects.contains_key(&ObjectKey::Mesh(instance.mesh))
            })
            .map(|(id, _)| *id)
            .collect();
        for id in free {
            let Some(instance) = self.held.remove(&id) else { continue };
            self.changes.push(SessionChange::Scene(SceneChange::SetInstance(id, instance)));
            if self.objects.contains_key(&ObjectKey::Receiver(id)) {
                self.changes.push(SessionChange::AddReceiver(id));
            }
        }
    }

    fn check(&self, limits: &Limits, geometry: bool, grids: bool) -> Result<(), WireError> {
        WireError::check("objects", self.objects.len(), limits.objects)?;
        if geometry {
            WireError::check("bytes of blobs", self.blob_bytes(), limits.session_blob_bytes)?;
            let of_instance = |object: &Object| match object {
                Object::Instance(instance) => self.solid.get(&instance.mesh).copied(),
                _ => None,
            };
            let triangles = self.objects.values().filter_map(of_instance).sum();
            WireError::check("triangles", triangles, limits.triangles)?;
        }
        if grids {
            let probes = total_probes(&self.objects);
            WireError::check("probes", probes, limits.probes)?;
        }
        Ok(())
    }

    /// Objects, triangles and bytes of blobs, for reports.
    pub(super) fn size(&self) -> (usize, usize, usize) {
        let triangles = self.solid.values().sum();
        (self.objects.len(), triangles, self.blob_bytes())
    }

    fn blob_bytes(&self) -> usize {
        self.blobs.values().map(|(blob, _)| blob.memory()).sum()
    }

    /// Whether a blob is on its way.
    pub(super) fn waits_for_blobs(&self) -> bool {
        !self.incoming.is_empty()
    }
}
