//! Light that changes, and what else changes whole pictures.

use bevy::{
    camera::ClearColorConfig,
    ecs::entity::EntityHashMap,
    light::{
        FogVolume, GeneratedEnvironmentMapLight, IrradianceVolume, LightProbe, Skybox,
        VolumetricFog, VolumetricLight,
    },
    math::Affine3A,
    pbr::{DistanceFog, Lightmap, ScreenSpaceAmbientOcclusion},
    prelude::*,
};
use farlight_core::DerivedLight;

use super::{Changes, Disturb, Notice};
use crate::{ProgressiveCamera, ProgressiveLighting, environment::Lights, lights::Group};

/// Adds the systems that notice light.
pub(super) fn build(app: &mut App) {
    app.add_systems(
        PostUpdate,
        (
            (told, environment, resources, places, cameras).in_set(Notice),
            (
                notice::<PointLight>,
                notice::<SpotLight>,
                notice::<DirectionalLight>,
                notice::<RectLight>,
                notice::<VolumetricLight>,
                notice::<EnvironmentMapLight>,
                notice::<GeneratedEnvironmentMapLight>,
                notice::<Skybox>,
                notice::<AmbientLight>,
                notice::<IrradianceVolume>,
                notice::<LightProbe>,
                notice::<Lightmap>,
                notice::<DistanceFog>,
                notice::<VolumetricFog>,
                notice::<FogVolume>,
                notice::<ScreenSpaceAmbientOcclusion>,
            )
                .in_set(Notice),
        ),
    );
}

fn told(mut changes: ResMut<Changes>, mut told: MessageReader<Disturb>) {
    for disturb in told.read() {
        changes.add(disturb.sphere, disturb.keep);
    }
}

/// The environment's light.
fn environment(
    mut changes: ResMut<Changes>,
    settings: Res<ProgressiveLighting>,
    set: Res<Lights>,
    group: Res<Group>,
    mut before: Local<Option<(ProgressiveLighting, u32)>>,
) {
    let same = before.as_ref().is_some_and(|(settings_before, cycle)| {
        *cycle == group.cycle && *settings_before == *settings
    });
    // A set is written only when it is another one.
    if !same || set.is_changed() {
        *before = Some((settings.clone(), group.cycle));
        changes.everywhere();
    }
}

/// The light that is everywhere, and the colour where nothing is.
fn resources(
    mut changes: ResMut<Changes>,
    ambient: Option<Res<GlobalAmbientLight>>,
    clear: Option<Res<ClearColor>>,
    mut before: Local<(Option<GlobalAmbientLight>, Option<Color>)>,
) {
    let ambient = ambient.as_deref();
    let clear = clear.map(|clear| clear.0);
    let same_ambient = match (ambient, &before.0) {
        (Some(now), Some(before)) => now.reflect_partial_eq(before).unwrap_or(false),
        (None, None) => true,
        _ => false,
    };
    if !same_ambient || clear != before.1 {
        *before = (ambient.cloned(), clear);
        changes.everywhere();
    }
}

/// Where lights, probes and fog are, and whether they are visible.
fn places(
    mut changes: ResMut<Changes>,
    all: Query<
        (Entity, &GlobalTransform, Option<&InheritedVisibility>),
        (
            Without<DerivedLight>,
            Or<(
                With<PointLight>,
                With<SpotLight>,
                With<DirectionalLight>,
                With<RectLight>,
                With<LightProbe>,
                With<FogVolume>,
            )>,
            Or<(Changed<GlobalTransform>, Changed<InheritedVisibility>)>,
        ),
    >,
    exists: Query<&GlobalTransform>,
    mut known: Local<EntityHashMap<(Affine3A, bool)>>,
) {
    let mut changed = false;
    for (entity, transform, visibility) in &all {
        let now = (transform.affine(), visibility.is_none_or(|visibility| visibility.get()));
        changed |= known.insert(entity, now) != Some(now);
    }
    if changed {
        known.retain(|entity, _| exists.contains(*entity));
        changes.everywhere();
    }
}

/// Components that light, or change what all see.
fn notice<C: Component + Clone + PartialReflect>(
    mut changes: ResMut<Changes>,
    components: Query<(Entity, &C), (Changed<C>, Without<DerivedLight>)>,
    mut removed: RemovedComponents<C>,
    mut known: Local<EntityHashMap<C>>,
) {
    let mut changed = false;
    for entity in removed.read() {
        changed |= known.remove(&entity).is_some();
    }
    for (entity, now) in &components {
        let before = known.insert(entity, now.clone());
        changed |= before.is_none_or(|before| now.reflect_partial_eq(&before) != Some(true));
    }
    if changed {
        changes.everywhere();
    }
}

/// What a camera clears with.
fn cameras(
    mut changes: ResMut<Changes>,
    cameras: Query<(Entity, &Camera), (Changed<Camera>, With<ProgressiveCamera>)>,
    mut known: Local<EntityHashMap<Option<Color>>>,
) {
    let mut changed = false;
    for (entity, camera) in &cameras {
        let now = match camera.clear_color {
            ClearColorConfig::Custom(color) => Some(color),
            ClearColorConfig::Default | ClearColorConfig::None => None,
        };
        changed |= known.insert(entity, now).is_some_and(|before| before != now);
    }
    if changed {
        changes.everywhere();
    }
}
