//! Meshes on their way to the solver.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, atomic::AtomicBool},
};

use bevy::{
    ecs::entity::EntityHashSet,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};
use farlight_gi_solver::{SceneChange, scene::MeshId};

use super::{
    Extractor,
    geometry::{self, Converted, convert},
    set_mesh,
};
use crate::{
    GiSettings, GiStatic,
    status::{GiMeter, Stage},
    uv1::StopOnDrop,
};

/// A mesh that instances use.
pub(super) struct MeshState {
    pub(super) id: MeshId,
    pub(super) users: EntityHashSet,
    pub(super) stage: MeshStage,
    /// The mesh to draw instead.
    replacement: Option<Handle<Mesh>>,
}

pub(super) enum MeshStage {
    /// The asset isn't loaded, or waits to be copied.
    Waiting,
    Converting(
        Task<Result<Converted, String>>,
        #[expect(dead_code, reason = "it acts when dropped")] StopOnDrop,
    ),
    Ready {
        /// Why instances can't receive light, if so.
        no_receiver: Option<String>,
    },
    Failed(String),
}

impl MeshState {
    fn is_unfinished(&self) -> bool {
        matches!(self.stage, MeshStage::Waiting | MeshStage::Converting(..))
    }
}

impl Extractor {
    /// The mesh behind a handle on an entity: itself, or the one that it was made from.
    pub(super) fn source_mesh(&self, mesh: AssetId<Mesh>) -> AssetId<Mesh> {
        self.made_from.get(&mesh).copied().unwrap_or(mesh)
    }

    /// Counts `entity` among the mesh's users and returns what is known of it.
    pub(super) fn use_mesh(&mut self, mesh: AssetId<Mesh>, entity: Entity) -> &MeshState {
        if !self.meshes.contains_key(&mesh) {
            let id = MeshId(self.new_id());
            let state = MeshState {
                id,
                users: EntityHashSet::default(),
                stage: MeshStage::Waiting,
                replacement: None,
            };
            self.meshes.insert(mesh, state);
        }
        let state = self.meshes.get_mut(&mesh).expect("it was just inserted");
        state.users.insert(entity);
        state
    }

    /// Has the entity draw the mesh with the second UV set from the next frame on.
    pub(super) fn swap_if_replaced(&mut self, entity: Entity, drawn: AssetId<Mesh>) {
        let replacement = self.meshes.get(&drawn).and_then(|state| state.replacement.clone());
        if let Some(replacement) = replacement {
            self.swaps.push((entity, drawn, replacement));
        }
    }

    /// Takes `entity` from the mesh's users; without users the mesh is forgotten.
    pub(super) fn release_mesh(&mut self, mesh: AssetId<Mesh>, entity: Entity) {
        let Some(state) = self.meshes.get_mut(&mesh) else { return };
        state.users.remove(&entity);
        if state.users.is_empty()
            && let Some(state) = self.meshes.remove(&mesh)
        {
            if let Some(replacement) = &state.replacement {
                self.made_from.remove(&replacement.id());
            }
            if matches!(state.stage, MeshStage::Ready { .. }) {
                self.changes.unused.push(SceneChange::RemoveMesh(state.id));
            }
        }
    }
}

/// Exchanges mesh handles; early in the frame, so that Bevy chooses pipelines for the new mesh.
pub(crate) fn swap_meshes(
    mut extractor: ResMut<Extractor>,
    mut drawn: Query<&mut Mesh3d, With<GiStatic>>,
) {
    for (entity, old, new) in extractor.swaps.drain(..) {
        if let Ok(mut mesh) = drawn.get_mut(entity)
            && mesh.id() == old
        {
            mesh.0 = new;
        }
    }
}

/// Starts and finishes the conversion of meshes.
pub(crate) fn convert_meshes(
    mut extractor: ResMut<Extractor>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    mut meshes: ResMut<Assets<Mesh>>,
    settings: Res<GiSettings>,
    meter: Res<GiMeter>,
) {
    let _measure = meter.measure(Stage::Extract as usize);
    let extractor = &mut *extractor;
    for event in events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event
            && let Some(state) = extractor.meshes.get_mut(id)
        {
            // A conversion under way is of old data; dropping the task cancels it.
            if !matches!(state.stage, MeshStage::Waiting) {
                state.stage = MeshStage::Waiting;
            }
        }
    }
    let unfinished = extractor
        .meshes
        .iter()
        .filter(|(_, state)| state.is_unfinished())
        .map(|(&id, _)| id)
        .collect::<Vec<_>>();
    for id in unfinished {
        advance(extractor, id, &mut meshes, settings.texels_per_metre);
        let busy = extractor.meshes.get(&id).is_some_and(|state| state.is_unfinished());
        extractor.converting += usize::from(busy && meshes.contains(id));
    }
}

fn advance(
    extractor: &mut Extractor,
    id: AssetId<Mesh>,
    meshes: &mut Assets<Mesh>,
    texels_per_metre: f32,
) {
    let Some(state) = extractor.meshes.get_mut(&id) else { return };
    match &mut state.stage {
        MeshStage::Waiting => {
            let Some(mesh) = meshes.get(id) else { return };
            // Meshes that only the GPU has can't say how large they are.
            if mesh.try_attributes().is_err() {
                state.stage = MeshStage::Failed(geometry::no_data());
                extractor.dirty.extend(state.users.iter().copied());
                return;
            }
            let bytes = mesh.get_vertex_buffer_size()
                + mesh.get_index_buffer_bytes().map_or(0, <[u8]>::len);
            if !extractor.may_copy(bytes) {
                return;
            }
            let copy = mesh.clone();
            let stop = Arc::new(AtomicBool::new(false));
            let stopper = StopOnDrop(stop.clone());
            let task = AsyncComputeTaskPool::get().spawn(async move {
                // A mesh that trips the converter up is left out; the game goes on.
                catch_unwind(AssertUnwindSafe(|| convert(&copy, texels_per_metre, &stop)))
                    .unwrap_or_else(|_| Err("it could not be converted".into()))
            });
            if let Some(state) = extractor.meshes.get_mut(&id) {
                state.stage = MeshStage::Converting(task, stopper);
            }
        }
        MeshStage::Converting(task, _) => {
            let Some(result) = block_on(poll_once(task)) else { return };
            finish(extractor, id, result, meshes);
        }
        MeshStage::Ready { .. } | MeshStage::Failed(_) => {}
    }
}

fn finish(
    extractor: &mut Extractor,
    id: AssetId<Mesh>,
    result: Result<Converted, String>,
    meshes: &mut Assets<Mesh>,
) {
    let Some(state) = extractor.meshes.get_mut(&id) else { return };
    extractor.dirty.extend(state.users.iter().copied());
    let converted = match result {
        Ok(converted) => converted,
        Err(reason) => {
            state.stage = MeshStage::Failed(reason);
            return;
        }
    };
    state.stage = MeshStage::Ready { no_receiver: converted.no_receiver };
    set_mesh(&mut extractor.changes, state.id, converted.geometry);
    match (converted.replacement, &state.replacement) {
        (Some(mesh), Some(handle)) => {
            if meshes.insert(handle.id(), *mesh).is_err() {
                warn!("a mesh with a second UV set vanished");
            }
        }
        (Some(mesh), None) => {
            let handle = meshes.add(*mesh);
            extractor.made_from.insert(handle.id(), id);
            state.replacement = Some(handle);
        }
        // The changed mesh has a usable second UV set of its own now; entities draw our copy.
        (None, Some(handle)) => {
            if let Some(mesh) = meshes.get(id).cloned()
                && meshes.insert(handle.id(), mesh).is_err()
            {
                warn!("a mesh with a second UV set vanished");
            }
        }
        (None, None) => {}
    }
}
