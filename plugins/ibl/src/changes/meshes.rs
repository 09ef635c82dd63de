//! Meshes that move, bend, appear and vanish.

use std::hash::{BuildHasher, Hash, Hasher};

use bevy::{
    camera::{primitives::Aabb, visibility::RenderLayers},
    light::{NotShadowCaster, NotShadowReceiver},
    math::Affine3A,
    mesh::{
        morph::{MeshMorphWeights, MorphWeights},
        skinning::SkinnedMesh,
    },
    platform::hash::FixedHasher,
    prelude::*,
};

use super::{Changes, KEEP_LIGHT, sphere};

/// What is known of a mesh.
#[derive(Debug, PartialEq)]
pub(super) struct Seen {
    pub(super) sphere: (Vec3, f32),
    pub(super) visible: bool,
    affine: Affine3A,
    mesh: AssetId<Mesh>,
    layers: RenderLayers,
    shadows: (bool, bool),
    /// Of joints and morph weights.
    pose: u64,
}

type SeenMesh = (
    Entity,
    Ref<'static, GlobalTransform>,
    Option<&'static Aabb>,
    Ref<'static, InheritedVisibility>,
    Ref<'static, Mesh3d>,
    Option<Ref<'static, RenderLayers>>,
    (Has<NotShadowCaster>, Has<NotShadowReceiver>),
    Option<&'static SkinnedMesh>,
    Option<Ref<'static, MeshMorphWeights>>,
);

/// Notes what moved, appeared, vanished. Comes first: it forgets the changes of the frame before.
pub(super) fn notice_meshes(
    mut changes: ResMut<Changes>,
    meshes: Query<SeenMesh>,
    joints: Query<Ref<GlobalTransform>>,
    weights: Query<Ref<MorphWeights>>,
    mut removed: RemovedComponents<Mesh3d>,
) {
    let changes = &mut *changes;
    changes.all.clear();
    if changes.uploading > 0 {
        changes.uploading -= 1;
        changes.everywhere();
    }
    for entity in removed.read() {
        if !meshes.contains(entity)
            && let Some(seen) = changes.known.remove(&entity)
            && seen.visible
        {
            changes.add(Some(seen.sphere), KEEP_LIGHT);
        }
    }
    for (entity, transform, aabb, visibility, mesh, layers, shadows, skin, morph) in &meshes {
        let bends = skin.is_some_and(|skin| {
            skin.joints.iter().any(|joint| joints.get(*joint).is_ok_and(|j| j.is_changed()))
        });
        let weighs = morph.as_ref().is_some_and(|morph| {
            morph.is_changed()
                || matches!(**morph, MeshMorphWeights::Reference(other)
                    if weights.get(other).is_ok_and(|weights| weights.is_changed()))
        });
        let known = changes.known.get(&entity);
        let may_differ = bends
            || weighs
            || transform.is_changed()
            || visibility.is_changed()
            || mesh.is_changed()
            || layers.as_ref().is_some_and(|layers| layers.is_changed())
            || known.is_none_or(|known| known.shadows != shadows);
        if !may_differ {
            continue;
        }
        let mut pose = FixedHasher.build_hasher();
        for joint in skin.iter().flat_map(|skin| skin.joints.iter()) {
            if let Ok(joint) = joints.get(*joint) {
                bits(&mut pose, &joint.affine().to_cols_array());
            }
        }
        match morph.as_deref() {
            Some(MeshMorphWeights::Value { weights }) => bits(&mut pose, weights),
            Some(MeshMorphWeights::Reference(other)) => {
                if let Ok(weights) = weights.get(*other) {
                    bits(&mut pose, weights.weights());
                }
            }
            None => {}
        }
        let now = Seen {
            sphere: sphere(&transform, aabb),
            visible: visibility.get(),
            affine: transform.affine(),
            mesh: mesh.id(),
            layers: layers.as_deref().cloned().unwrap_or_default(),
            shadows,
            pose: pose.finish(),
        };
        if known == Some(&now) {
            continue;
        }
        // What is kept of a mesh moves along with it; of what appears, nothing is kept.
        let moves = known.is_some_and(|before| before.visible && before.mesh == now.mesh);
        // The places that it leaves, and those that it shadowed.
        let left = known
            .filter(|before| before.visible && (before.sphere != now.sphere || !now.visible))
            .map(|before| before.sphere);
        if let Some(left) = left {
            changes.add(Some(left), KEEP_LIGHT);
        }
        if now.visible {
            changes.add(Some(now.sphere), if moves { KEEP_LIGHT } else { 0.0 });
        }
        changes.known.insert(entity, now);
    }
}

fn bits(hasher: &mut impl Hasher, values: &[f32]) {
    for value in values {
        value.to_bits().hash(hasher);
    }
}
