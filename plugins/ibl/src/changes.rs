//! What changed in the world: pictures that are kept forget what it touches.

use bevy::{
    camera::primitives::Aabb,
    ecs::entity::EntityHashMap,
    light::Skybox,
    mesh::{morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
};
use farlight_core::DerivedLight;

use crate::{ProgressiveLighting, environment::Lights, lights::Group};

/// Changes that are told apart; more become one that is everywhere.
pub(crate) const MOST: usize = 16;
/// Frames of a picture that count on when light changes everywhere: few enough to follow, enough not
/// to flicker.
pub(crate) const KEEP_LIGHT: f32 = 8.0;

/// Something that Bevy's change detection doesn't see has changed what cameras see: a texture that
/// was written on the GPU, a shader's own clock.
#[derive(Message, Clone, Copy, Debug, PartialEq)]
pub struct Disturb {
    /// Where: a sphere in the world (centre, radius in metres); everywhere without.
    pub sphere: Option<(Vec3, f32)>,
    /// How many frames of what is kept still count there; 0 starts anew.
    pub keep: f32,
}

/// What changed in this frame.
#[derive(Resource, Debug, Default)]
pub(crate) struct Changes {
    pub(crate) all: Vec<Disturb>,
    known: EntityHashMap<(Vec3, f32)>,
}

impl Changes {
    pub(crate) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    fn add(&mut self, sphere: Option<(Vec3, f32)>, keep: f32) {
        if self.all.len() < MOST {
            self.all.push(Disturb { sphere, keep });
        } else {
            self.all.clear();
            self.all.extend([Disturb { sphere: None, keep }; MOST]);
        }
    }
}

/// A mesh that is seen, as its sphere.
fn sphere(transform: &GlobalTransform, aabb: Option<&Aabb>) -> (Vec3, f32) {
    match aabb {
        Some(aabb) => (
            transform.transform_point(aabb.center.into()),
            transform.radius_vec3a(aabb.half_extents).max(1e-3),
        ),
        None => (transform.translation(), 1.0),
    }
}

type SeenMesh = (
    Entity,
    Ref<'static, GlobalTransform>,
    Option<&'static Aabb>,
    Ref<'static, InheritedVisibility>,
    Ref<'static, Mesh3d>,
    Option<Ref<'static, MeshMaterial3d<StandardMaterial>>>,
    Option<&'static SkinnedMesh>,
    Option<Ref<'static, MeshMorphWeights>>,
);

/// Notes what moved, appeared, vanished.
pub(crate) fn notice_meshes(
    mut changes: ResMut<Changes>,
    meshes: Query<SeenMesh>,
    joints: Query<Ref<GlobalTransform>>,
    mut removed: RemovedComponents<Mesh3d>,
) {
    let changes = &mut *changes;
    changes.all.clear();
    for (entity, transform, aabb, visibility, mesh, material, skin, morph) in &meshes {
        let bends = skin.is_some_and(|skin| {
            skin.joints.iter().any(|joint| joints.get(*joint).is_ok_and(|j| j.is_changed()))
        }) || morph.is_some_and(|morph| morph.is_changed());
        let changed = transform.is_changed()
            || visibility.is_changed()
            || mesh.is_changed()
            || material.is_some_and(|material| material.is_changed());
        let before = changes.known.get(&entity).copied();
        if !changed && !bends && before.is_some() {
            continue;
        }
        let now = sphere(&transform, aabb);
        if visibility.get() {
            changes.add(Some(now), 0.0);
        }
        // The places that it leaves, and those that it shadowed.
        if let Some(before) = before
            && before != now
        {
            changes.add(Some(before), KEEP_LIGHT);
        }
        changes.known.insert(entity, now);
    }
    for entity in removed.read() {
        if let Some(sphere) = changes.known.remove(&entity) {
            changes.add(Some(sphere), KEEP_LIGHT);
        }
    }
}

/// Notes light that changed.
pub(crate) fn notice_light(
    mut changes: ResMut<Changes>,
    settings: Res<ProgressiveLighting>,
    set: Res<Lights>,
    group: Res<Group>,
    ambient: Option<Res<GlobalAmbientLight>>,
    mut cycle: Local<u32>,
    lights: Query<
        (),
        (
            Without<DerivedLight>,
            Or<(With<PointLight>, With<SpotLight>, With<DirectionalLight>, With<RectLight>)>,
            Or<(
                Changed<PointLight>,
                Changed<SpotLight>,
                Changed<DirectionalLight>,
                Changed<RectLight>,
                Changed<GlobalTransform>,
                Changed<InheritedVisibility>,
            )>,
        ),
    >,
    environments: Query<
        (),
        Or<(Changed<EnvironmentMapLight>, Changed<Skybox>, Changed<AmbientLight>)>,
    >,
    mut gone: (
        RemovedComponents<PointLight>,
        RemovedComponents<SpotLight>,
        RemovedComponents<DirectionalLight>,
        RemovedComponents<EnvironmentMapLight>,
        RemovedComponents<Skybox>,
    ),
    mut told: MessageReader<Disturb>,
) {
    for disturb in told.read() {
        changes.add(disturb.sphere, disturb.keep);
    }
    let vanished = gone.0.read().count()
        + gone.1.read().count()
        + gone.2.read().count()
        + gone.3.read().count()
        + gone.4.read().count();
    let other_group = std::mem::replace(&mut *cycle, group.cycle) != group.cycle;
    if settings.is_changed()
        || set.is_changed()
        || other_group
        || vanished > 0
        || ambient.is_some_and(|ambient| ambient.is_changed())
        || !lights.is_empty()
        || !environments.is_empty()
    {
        changes.add(None, KEEP_LIGHT);
    }
}

/// Notes assets that changed: which entities show them isn't asked.
pub(crate) fn notice_assets<A: Asset>(
    mut changes: ResMut<Changes>,
    mut events: MessageReader<AssetEvent<A>>,
) {
    let changed = events
        .read()
        .any(|event| matches!(event, AssetEvent::Added { .. } | AssetEvent::Modified { .. }));
    if changed {
        changes.add(None, KEEP_LIGHT);
    }
}
