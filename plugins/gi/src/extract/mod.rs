//! From Bevy's world to scene changes.
//!
//! Systems look at what changed this frame and note [`SceneChange`]s; the last one submits them to
//! the backend as one snapshot. Heavy work (copying triangles, making second UV sets, shrinking
//! images) runs in tasks.

mod geometry;
mod instances;
mod lights;
mod materials;
mod meshes;
mod pixels;
mod sky;
mod textures;
mod volumes;

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use bevy::{
    ecs::entity::{EntityHashMap, EntityHashSet},
    platform::collections::HashMap,
    prelude::*,
};
use farlight_gi_solver::{
    Scene, SceneChange,
    scene::{InstanceId, LightId, MaterialId, MeshId, TextureId},
    session::{GridId, ProbeGrid, SessionChange, SnapshotId},
};

use crate::{
    GiStatus,
    backend::GiBackend,
    status::{GiMeter, Remarks, Stage, SubmitTimes},
};

pub(crate) use instances::extract_instances;
pub(crate) use lights::extract_lights;
pub(crate) use materials::extract_materials;
pub(crate) use meshes::{convert_meshes, swap_meshes};
pub(crate) use sky::{SkyState, extract_sky};
pub(crate) use textures::convert_textures;
pub(crate) use volumes::extract_volumes;

use instances::InstanceState;
use materials::{MaterialKey, MaterialState};
use meshes::MeshState;
use textures::TextureState;

/// Most bytes of meshes and images that are copied for tasks in one frame; a larger one is copied
/// alone.
const COPY_BUDGET: usize = 1 << 20;

/// The scene as the backend knows it: what was submitted so far.
///
/// Heavy data is shared, so a clone is cheap; hand it to a `World` of the solver to compute
/// whatever the game wants of the same scene.
#[derive(Resource, Default)]
pub struct ExtractedScene {
    /// Geometry, materials, lights and sky.
    pub scene: Scene,
    /// The instances that have lightmaps.
    pub receivers: BTreeSet<InstanceId>,
    /// The probe volumes.
    pub grids: BTreeMap<GridId, ProbeGrid>,
    /// The newest snapshot.
    pub snapshot: SnapshotId,
}

impl ExtractedScene {
    fn apply(&mut self, change: &SessionChange) {
        match change {
            SessionChange::Scene(change) => self.scene.apply(change.clone()),
            SessionChange::AddReceiver(id) => drop(self.receivers.insert(*id)),
            SessionChange::RemoveReceiver(id) => drop(self.receivers.remove(id)),
            SessionChange::SetGrid(id, grid) => drop(self.grids.insert(*id, *grid)),
            SessionChange::RemoveGrid(id) => drop(self.grids.remove(id)),
        }
    }

    /// Everything, for a backend that knows nothing.
    fn all(&self) -> Vec<SessionChange> {
        self.scene
            .changes()
            .map(SessionChange::Scene)
            .chain(self.receivers.iter().map(|&id| SessionChange::AddReceiver(id)))
            .chain(self.grids.iter().map(|(&id, &grid)| SessionChange::SetGrid(id, grid)))
            .collect()
    }
}

/// Changes of one frame, in groups so that what is named comes before what names it.
#[derive(Default)]
struct Changes {
    removals: Vec<SessionChange>,
    assets: Vec<SceneChange>,
    instances: Vec<SceneChange>,
    receivers: Vec<SessionChange>,
    lights: Vec<SceneChange>,
    unused: Vec<SceneChange>,
}

impl Changes {
    fn take(&mut self) -> Vec<SessionChange> {
        let mut all = std::mem::take(&mut self.removals);
        all.extend(self.assets.drain(..).map(SessionChange::Scene));
        all.extend(self.instances.drain(..).map(SessionChange::Scene));
        all.append(&mut self.receivers);
        all.extend(self.lights.drain(..).map(SessionChange::Scene));
        all.extend(self.unused.drain(..).map(SessionChange::Scene));
        all
    }
}

/// What is known of the world, to tell what changed.
#[derive(Resource, Default)]
pub(crate) struct Extractor {
    changes: Changes,
    /// Instances to look at this frame.
    dirty: EntityHashSet,
    instances: EntityHashMap<InstanceState>,
    meshes: HashMap<AssetId<Mesh>, MeshState>,
    /// From meshes that we made (with a second UV set) to the ones they stand for.
    made_from: HashMap<AssetId<Mesh>, AssetId<Mesh>>,
    /// Mesh handles to exchange at the start of the next frame: entity, old, new.
    swaps: Vec<(Entity, AssetId<Mesh>, Handle<Mesh>)>,
    materials: HashMap<MaterialKey, MaterialState>,
    textures: HashMap<AssetId<Image>, TextureState>,
    lights: EntityHashMap<u32>,
    frame: u32,
    next_id: u64,
    /// Instances whose lightmaps go at the start of the next frame.
    unlit: EntityHashSet,
    copied_bytes: usize,
    /// Loaded meshes and images that aren't submitted yet.
    converting: usize,
    submit_times: SubmitTimes,
    resend: bool,
}

impl Extractor {
    fn new_id(&mut self) -> u64 {
        self.next_id += 1;
        self.next_id
    }

    /// Whether `bytes` may be copied this frame.
    fn may_copy(&mut self, bytes: usize) -> bool {
        let may = self.copied_bytes == 0 || self.copied_bytes + bytes <= COPY_BUDGET;
        if may {
            self.copied_bytes += bytes;
        }
        may
    }

    /// Submit everything again, for example to a new backend.
    pub(crate) fn resend(&mut self) {
        self.resend = true;
    }

    /// Instances whose lightmaps must go now.
    pub(crate) fn take_unlit(&mut self) -> EntityHashSet {
        std::mem::take(&mut self.unlit)
    }

    /// Whether the instance is (still) a receiver.
    pub(crate) fn is_receiver(&self, entity: Entity) -> bool {
        self.instances.get(&entity).is_some_and(InstanceState::is_receiver)
    }

    pub(crate) fn submit_times(&mut self) -> &mut SubmitTimes {
        &mut self.submit_times
    }
}

/// The entity's id as an instance, a light or a grid.
fn instance_id(entity: Entity) -> InstanceId {
    InstanceId(entity.to_bits())
}

fn light_id(entity: Entity) -> LightId {
    LightId(entity.to_bits())
}

fn grid_id(entity: Entity) -> GridId {
    GridId(entity.to_bits())
}

/// Hands this frame's changes to the backend.
pub(crate) fn submit(
    mut extractor: ResMut<Extractor>,
    mut extracted: ResMut<ExtractedScene>,
    backend: Option<ResMut<GiBackend>>,
    mut status: ResMut<GiStatus>,
    mut remarks: ResMut<Remarks>,
    meter: Res<GiMeter>,
) {
    let _measure = meter.measure(Stage::Extract as usize);
    extractor.frame = extractor.frame.wrapping_add(1);
    extractor.copied_bytes = 0;
    remarks.show(&mut status);
    status.bypass_change_detection().converting = std::mem::take(&mut extractor.converting);
    let mut changes = extractor.changes.take();
    for change in &changes {
        extracted.apply(change);
    }
    let Some(mut backend) = backend else { return };
    if std::mem::take(&mut extractor.resend) || backend.0.lost_scene() {
        changes = extracted.all();
    }
    if changes.is_empty() {
        return;
    }
    extracted.snapshot.0 += 1;
    status.submitted = extracted.snapshot;
    status.quality.converged = false;
    status.receivers = extracted.receivers.len();
    extractor.submit_times.submitted(extracted.snapshot);
    backend.0.submit(extracted.snapshot, changes);
}

/// Notes that an asset's data changed.
fn set_mesh(changes: &mut Changes, id: MeshId, mesh: Arc<farlight_gi_solver::scene::Mesh>) {
    changes.assets.push(SceneChange::SetMesh(id, mesh));
}

fn set_texture(
    changes: &mut Changes,
    id: TextureId,
    texture: Arc<farlight_gi_solver::scene::Texture>,
) {
    changes.assets.push(SceneChange::SetTexture(id, texture));
}

fn set_material(
    changes: &mut Changes,
    id: MaterialId,
    material: farlight_gi_solver::scene::Material,
) {
    changes.assets.push(SceneChange::SetMaterial(id, material));
}
