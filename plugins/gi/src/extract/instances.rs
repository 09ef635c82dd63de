//! Static meshes in the world.

use bevy::{
    ecs::query::QueryData,
    mesh::{morph::MeshMorphWeights, skinning::SkinnedMesh},
    pbr::Lightmap,
    prelude::*,
};
use farlight_core::{BakedSurface, DiffuseReflectance};
use farlight_gi_solver::{SceneChange, scene::Instance, session::SessionChange};

use super::{
    Extractor, instance_id,
    materials::{MaterialKey, Shading},
    meshes::MeshStage,
};
use crate::{
    GiLightmaps, GiStatic,
    status::{GiMeter, Remarks, Stage},
};

/// What was submitted of an instance.
#[derive(Default)]
pub(crate) struct InstanceState {
    mesh: Option<AssetId<Mesh>>,
    material: Option<MaterialKey>,
    submitted: Option<Instance>,
    receiver: bool,
}

impl InstanceState {
    pub(super) fn is_receiver(&self) -> bool {
        self.receiver
    }
}

/// What is looked at of an instance.
#[derive(QueryData)]
pub(crate) struct Row {
    mesh: &'static Mesh3d,
    material: Option<&'static MeshMaterial3d<StandardMaterial>>,
    reflectance: Has<DiffuseReflectance>,
    transform: &'static GlobalTransform,
    visible: &'static InheritedVisibility,
    skinned: Has<SkinnedMesh>,
    morphed: Has<MeshMorphWeights>,
    lightmapped: Has<Lightmap>,
    baked: Has<BakedSurface>,
}

type ChangedRow = Or<(
    Added<GiStatic>,
    Changed<Mesh3d>,
    Changed<MeshMaterial3d<StandardMaterial>>,
    Added<DiffuseReflectance>,
    Added<BakedSurface>,
    Changed<GlobalTransform>,
    Changed<InheritedVisibility>,
)>;

/// Looks at instances that changed, or whose mesh or material did.
pub(crate) fn extract_instances(
    mut extractor: ResMut<Extractor>,
    mut remarks: ResMut<Remarks>,
    lightmaps: Res<GiLightmaps>,
    changed: Query<Entity, (With<GiStatic>, ChangedRow)>,
    rows: Query<Row, With<GiStatic>>,
    mut removed: (
        RemovedComponents<GiStatic>,
        RemovedComponents<Mesh3d>,
        RemovedComponents<MeshMaterial3d<StandardMaterial>>,
        RemovedComponents<DiffuseReflectance>,
        RemovedComponents<BakedSurface>,
    ),
    meter: Res<GiMeter>,
) {
    let _measure = meter.measure(Stage::Extract as usize);
    let extractor = &mut *extractor;
    let mut dirty = std::mem::take(&mut extractor.dirty);
    dirty.extend(&changed);
    dirty.extend(removed.0.read().chain(removed.1.read()));
    dirty.extend(removed.2.read().chain(removed.3.read()).chain(removed.4.read()));
    for entity in dirty.drain() {
        match rows.get(entity) {
            Ok(row) => {
                let own_lightmap = row.lightmapped && lightmaps.placement(entity).is_none();
                look(extractor, &mut remarks, entity, &row, own_lightmap);
            }
            Err(_) => {
                forget(extractor, entity);
                remarks.clear(entity);
            }
        }
    }
    // Keep the allocation.
    if extractor.dirty.is_empty() {
        extractor.dirty = dirty;
    }
}

fn look(
    extractor: &mut Extractor,
    remarks: &mut Remarks,
    entity: Entity,
    row: &RowItem,
    own_lightmap: bool,
) {
    if !row.visible.get() {
        return withdraw(extractor, entity);
    }
    let refuse = |extractor: &mut Extractor, remarks: &mut Remarks, reason: String| {
        withdraw(extractor, entity);
        remarks.note(entity, reason);
    };
    if row.skinned || row.morphed {
        return refuse(
            extractor,
            remarks,
            "it is deformed by bones or morph targets; tag it GiDynamic".into(),
        );
    }
    let material = match row.material {
        Some(material) => MaterialKey::Standard(material.id()),
        None if row.reflectance => MaterialKey::Reflectance(entity),
        None => {
            let reason = "it has no MeshMaterial3d<StandardMaterial>, nor a DiffuseReflectance that \
                          says what its own material reflects";
            return refuse(extractor, remarks, reason.into());
        }
    };
    let affine = row.transform.affine();
    if !affine.is_finite() || affine.matrix3.determinant() == 0.0 {
        return refuse(extractor, remarks, "its transform isn't finite, or flattens it".into());
    }

    let mesh_id = extractor.source_mesh(row.mesh.id());
    let state = extractor.instances.entry(entity).or_default();
    let old = (state.mesh.replace(mesh_id), state.material.replace(material));
    let used_material = extractor.use_material(material, entity);
    let (shading, material_id, remark) =
        (used_material.shading, used_material.id, used_material.remark.clone());
    let used_mesh = extractor.use_mesh(mesh_id, entity);
    let mesh_key = used_mesh.id;
    let readiness = match &used_mesh.stage {
        MeshStage::Waiting | MeshStage::Converting(..) => None,
        MeshStage::Ready { no_receiver } => Some(Ok(no_receiver.clone())),
        MeshStage::Failed(reason) => Some(Err(reason.clone())),
    };
    if let Some(old) = old.0.filter(|&old| old != mesh_id) {
        extractor.release_mesh(old, entity);
    }
    if let Some(old) = old.1.filter(|&old| old != material) {
        extractor.release_material(old, entity);
    }

    let no_receiver = match (readiness, shading) {
        // Until the mesh is converted what was submitted stays, for example while it is edited.
        (None, _) | (_, Shading::Unknown) => return,
        (Some(Err(reason)), _) => return refuse(extractor, remarks, reason),
        (_, Shading::Blended) => {
            let reason = "it is blended: it neither blocks, reflects nor receives light here";
            return refuse(extractor, remarks, reason.into());
        }
        (Some(Ok(no_receiver)), Shading::Opaque) => no_receiver,
    };
    extractor.swap_if_replaced(entity, row.mesh.id());

    let instance = Instance { mesh: mesh_key, material: material_id, transform: affine };
    let id = instance_id(entity);
    let state = extractor.instances.entry(entity).or_default();
    if state.submitted.as_ref() != Some(&instance) {
        state.submitted = Some(instance.clone());
        extractor.changes.instances.push(SceneChange::SetInstance(id, instance));
    }
    let receiver = no_receiver.is_none() && !own_lightmap && !row.baked;
    if receiver != state.receiver {
        state.receiver = receiver;
        if receiver {
            extractor.changes.receivers.push(SessionChange::AddReceiver(id));
        } else {
            extractor.changes.removals.push(SessionChange::RemoveReceiver(id));
            extractor.unlit.insert(entity);
        }
    }
    if row.baked {
        remarks.clear(entity);
    } else if own_lightmap {
        remarks.note(entity, "it has a Lightmap of its own; it blocks and reflects light");
    } else if let Some(reason) = no_receiver {
        remarks.note(entity, format!("it blocks and reflects light but has no lightmap: {reason}"));
    } else if let Some(remark) = remark {
        remarks.note(entity, remark);
    } else {
        remarks.clear(entity);
    }
}

/// Takes an instance out of the scene; its mesh and material stay known.
fn withdraw(extractor: &mut Extractor, entity: Entity) {
    let Some(state) = extractor.instances.get_mut(&entity) else { return };
    let id = instance_id(entity);
    if std::mem::take(&mut state.receiver) {
        extractor.changes.removals.push(SessionChange::RemoveReceiver(id));
        extractor.unlit.insert(entity);
    }
    if state.submitted.take().is_some() {
        extractor.changes.removals.push(SessionChange::Scene(SceneChange::RemoveInstance(id)));
    }
}

/// Takes an instance out and lets go of what it used.
fn forget(extractor: &mut Extractor, entity: Entity) {
    withdraw(extractor, entity);
    let Some(state) = extractor.instances.remove(&entity) else { return };
    if let Some(mesh) = state.mesh {
        extractor.release_mesh(mesh, entity);
    }
    if let Some(material) = state.material {
        extractor.release_material(material, entity);
    }
}
