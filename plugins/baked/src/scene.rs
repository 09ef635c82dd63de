//! Scenes that are spawned by their manifest.

use bevy::{
    gltf::GltfAssetLabel,
    prelude::*,
    world_serialization::{WorldAsset, WorldAssetRoot},
};

use crate::{BakedLighting, BakedManifest, BakedScene};

/// Loads manifests.
pub(crate) fn load(
    mut commands: Commands,
    scenes: Query<(Entity, &BakedScene), Changed<BakedScene>>,
    mut lighting: Query<&mut BakedLighting>,
    server: Res<AssetServer>,
) {
    for (entity, BakedScene(path)) in &scenes {
        let manifest = server.load::<BakedManifest>(path.clone());
        match lighting.get_mut(entity) {
            Ok(mut lighting) => {
                if lighting.manifest != manifest {
                    lighting.manifest = manifest;
                    commands.entity(entity).try_remove::<WorldAssetRoot>();
                }
            }
            Err(_) => {
                commands.entity(entity).try_insert(BakedLighting::new(manifest));
            }
        }
    }
}

/// Spawns the scenes that loaded manifests name.
pub(crate) fn spawn(
    mut commands: Commands,
    waiting: Query<(Entity, &BakedLighting), (With<BakedScene>, Without<WorldAssetRoot>)>,
    manifests: Res<Assets<BakedManifest>>,
    server: Res<AssetServer>,
) {
    for (entity, lighting) in &waiting {
        if let Some(manifest) = manifests.get(&lighting.manifest) {
            let path = GltfAssetLabel::Scene(0).from_asset(manifest.scene.clone());
            let scene: Handle<WorldAsset> = server.load(path);
            commands.entity(entity).try_insert(WorldAssetRoot(scene));
        }
    }
}
