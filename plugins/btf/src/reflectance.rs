//! What measured materials tell lighting: the colour that they reflect.

use bevy::{platform::collections::HashSet, prelude::*};
use farlight_core::DiffuseReflectance;

use crate::{BtfMaterial, loading::PreparedBtfs};

/// Keeps [`DiffuseReflectance`] on entities with measured materials. When data arrives, `finish` of
/// `loading.rs` marks its materials as changed, so these and the entities are all there is to watch.
pub(crate) fn update(
    mut commands: Commands,
    mut events: MessageReader<AssetEvent<BtfMaterial>>,
    materials: Res<Assets<BtfMaterial>>,
    prepared: Res<PreparedBtfs>,
    mut users: Query<(Entity, Ref<MeshMaterial3d<BtfMaterial>>, Option<&mut DiffuseReflectance>)>,
    mut removed: RemovedComponents<MeshMaterial3d<BtfMaterial>>,
) {
    for entity in removed.read() {
        // It may have another one since, or be gone.
        if !users.contains(entity)
            && let Ok(mut entity) = commands.get_entity(entity)
        {
            entity.try_remove::<DiffuseReflectance>();
        }
    }
    let modified: HashSet<AssetId<BtfMaterial>> = events
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    for (entity, user, known) in &mut users {
        if !user.is_changed() && !modified.contains(&user.id()) {
            continue;
        }
        let material = materials.get(user.id());
        let now = material.map(|material| reflectance(material, &prepared)).unwrap_or_default();
        match known {
            Some(mut known) => drop(known.set_if_neq(now)),
            None => drop(commands.entity(entity).try_insert(now)),
        }
    }
}

/// The mean colour times the gain, at most all of the light.
fn reflectance(material: &BtfMaterial, prepared: &PreparedBtfs) -> DiffuseReflectance {
    let gain = if material.gain.is_finite() { material.gain } else { 1.0 };
    let ready = prepared.ready.get(&material.btf.id());
    DiffuseReflectance {
        albedo: ready.map(|ready| (gain * ready.coarse.mean).clamp(Vec3::ZERO, Vec3::ONE)),
        double_sided: material.double_sided,
    }
}
