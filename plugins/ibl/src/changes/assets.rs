//! Meshes, materials and images that change.

use std::any::TypeId;

use bevy::{
    asset::UntypedAssetId,
    ecs::entity::EntityHashMap,
    light::{IrradianceVolume, Skybox},
    pbr::Lightmap,
    platform::collections::HashSet,
    prelude::*,
};

use super::{Changes, Notice};

/// Has pictures follow materials: [`App::watch_material`](WatchMaterial::watch_material).
pub trait WatchMaterial {
    /// Pictures are refined anew where a material of this type is changed, replaced by another, or one
    /// of its images is: those that are marked `#[dependency]`. `StandardMaterial` is watched already.
    fn watch_material<M: Material>(&mut self) -> &mut Self;
}

impl WatchMaterial for App {
    fn watch_material<M: Material>(&mut self) -> &mut Self {
        self.add_systems(
            PostUpdate,
            notice_material::<M>.in_set(Notice).run_if(resource_exists::<Assets<M>>),
        )
    }
}

/// Whether one of `events` is about content that is new.
fn renewed<A: Asset>(
    events: &mut MessageReader<AssetEvent<A>>,
    mut matters: impl FnMut(AssetId<A>) -> bool,
) -> bool {
    let mut any = false;
    for event in events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event {
            any = any || matters(*id);
        }
    }
    any
}

/// Notes what entities are made of.
fn notice_material<M: Material>(
    mut changes: ResMut<Changes>,
    mut events: MessageReader<AssetEvent<M>>,
    mut images: MessageReader<AssetEvent<Image>>,
    materials: Res<Assets<M>>,
    changed: Query<(Entity, &MeshMaterial3d<M>), Changed<MeshMaterial3d<M>>>,
    all: Query<&MeshMaterial3d<M>>,
    mut known: Local<EntityHashMap<AssetId<M>>>,
    mut removed: RemovedComponents<MeshMaterial3d<M>>,
) {
    let changes = &mut *changes;
    let touch = |changes: &mut Changes, entity: Entity| {
        if let Some(seen) = changes.known.get(&entity)
            && seen.visible
        {
            let sphere = seen.sphere;
            changes.add(Some(sphere), 0.0);
        }
    };
    for entity in removed.read() {
        if known.remove(&entity).is_some() {
            touch(changes, entity);
        }
    }
    for (entity, material) in &changed {
        if known.insert(entity, material.id()) != Some(material.id()) {
            touch(changes, entity);
        }
    }
    let is_shown = |id: AssetId<M>| all.iter().any(|material| material.id() == id);
    let mut depends = None;
    let mut is_image = |id: AssetId<Image>| {
        depends
            .get_or_insert_with(|| {
                let mut all = HashSet::<UntypedAssetId>::default();
                for (_, material) in materials.iter() {
                    material.visit_dependencies(&mut |id| {
                        if id.type_id() == TypeId::of::<Image>() {
                            all.insert(id);
                        }
                    });
                }
                all
            })
            .contains(&id.untyped())
    };
    let material = renewed(&mut events, is_shown);
    let image = renewed(&mut images, &mut is_image);
    if material || image {
        changes.uploads();
    }
}

/// Notes shapes, and images that light: those of materials are noted with them.
pub(super) fn notice_assets(
    mut changes: ResMut<Changes>,
    mut meshes: MessageReader<AssetEvent<Mesh>>,
    mut images: MessageReader<AssetEvent<Image>>,
    shown: Query<&Mesh3d>,
    skies: Query<&Skybox>,
    maps: Query<&EnvironmentMapLight>,
    volumes: Query<&IrradianceVolume>,
    lightmaps: Query<&Lightmap>,
) {
    let mesh = renewed(&mut meshes, |id| shown.iter().any(|mesh| mesh.id() == id));
    let image = renewed(&mut images, |id| {
        skies.iter().any(|sky| sky.image.as_ref().is_some_and(|image| image.id() == id))
            || maps.iter().any(|map| map.diffuse_map.id() == id || map.specular_map.id() == id)
            || volumes.iter().any(|volume| volume.voxels.id() == id)
            || lightmaps.iter().any(|lightmap| lightmap.image.id() == id)
    });
    if mesh || image {
        changes.uploads();
    }
}
