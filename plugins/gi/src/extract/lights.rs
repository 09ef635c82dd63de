//! Bevy's punctual lights.

use std::f32::consts::PI;

use bevy::prelude::*;
use farlight_core::DerivedLight;
use farlight_gi_solver::{
    SceneChange,
    scene::{Light, LightKind},
};

use super::{ExtractedScene, Extractor, light_id};
use crate::status::{GiMeter, Remarks, Stage};

type Placed<L> =
    (Entity, Ref<'static, L>, Ref<'static, GlobalTransform>, Ref<'static, InheritedVisibility>);

/// Looks at all lights, which are few, and notes those that differ from what was submitted.
pub(crate) fn extract_lights(
    mut extractor: ResMut<Extractor>,
    extracted: Res<ExtractedScene>,
    mut remarks: ResMut<Remarks>,
    points: Query<Placed<PointLight>, Without<DerivedLight>>,
    spots: Query<Placed<SpotLight>, Without<DerivedLight>>,
    suns: Query<Placed<DirectionalLight>, Without<DerivedLight>>,
    areas: Query<Entity, (Added<RectLight>, Without<DerivedLight>)>,
    meter: Res<GiMeter>,
) {
    let _measure = meter.measure(Stage::Extract as usize);
    let extractor = &mut *extractor;
    let frame = extractor.frame;
    let mut see = |entity: Entity, changed: bool, light: &dyn Fn() -> Light| {
        let known = extractor.lights.insert(entity, frame).is_some();
        if known && !changed {
            return;
        }
        let light = light();
        if !is_finite(&light) {
            extractor.lights.remove(&entity);
            remarks.note(entity, "the light's place or strength isn't finite");
            if known {
                extractor.changes.lights.push(SceneChange::RemoveLight(light_id(entity)));
            }
            return;
        }
        remarks.clear(entity);
        if extracted.scene.lights.get(&light_id(entity)) != Some(&light) || !known {
            extractor.changes.lights.push(SceneChange::SetLight(light_id(entity), light));
        }
    };
    for (entity, light, transform, visible) in &points {
        if visible.get() {
            let changed = light.is_changed() || transform.is_changed();
            see(entity, changed, &|| point(&light, &transform));
        }
    }
    for (entity, light, transform, visible) in &spots {
        if visible.get() {
            let changed = light.is_changed() || transform.is_changed();
            see(entity, changed, &|| spot(&light, &transform));
        }
    }
    for (entity, light, transform, visible) in &suns {
        if visible.get() {
            let changed = light.is_changed() || transform.is_changed();
            see(entity, changed, &|| sun(&light, &transform));
        }
    }
    for entity in &areas {
        remarks.note(entity, "rectangular lights aren't solved yet; use an emissive mesh");
    }
    // What wasn't seen is gone: despawned, hidden, or marked as derived.
    let changes = &mut extractor.changes;
    extractor.lights.retain(|&entity, &mut seen| {
        if seen != frame {
            changes.lights.push(SceneChange::RemoveLight(light_id(entity)));
        }
        seen == frame
    });
}

/// Linear colour times a strength.
fn rgb(color: Color, strength: f32) -> Vec3 {
    color.to_linear().to_vec3() * strength
}

/// Lumens over 4 pi are candela, as in Bevy's shader, for spot lights too.
fn point(light: &PointLight, transform: &GlobalTransform) -> Light {
    Light {
        kind: LightKind::Point,
        position: transform.translation(),
        direction: Vec3::NEG_Z,
        intensity: rgb(light.color, light.intensity / (4.0 * PI)),
        range: light.range,
    }
}

fn spot(light: &SpotLight, transform: &GlobalTransform) -> Light {
    Light {
        kind: LightKind::Spot { inner_angle: light.inner_angle, outer_angle: light.outer_angle },
        position: transform.translation(),
        direction: transform.forward().as_vec3(),
        intensity: rgb(light.color, light.intensity / (4.0 * PI)),
        range: light.range,
    }
}

fn sun(light: &DirectionalLight, transform: &GlobalTransform) -> Light {
    Light {
        kind: LightKind::Directional,
        position: Vec3::ZERO,
        direction: transform.forward().as_vec3(),
        intensity: rgb(light.color, light.illuminance),
        range: f32::INFINITY,
    }
}

fn is_finite(light: &Light) -> bool {
    let angles = match light.kind {
        LightKind::Spot { inner_angle, outer_angle } => {
            inner_angle.is_finite() && outer_angle.is_finite()
        }
        LightKind::Point | LightKind::Directional => true,
    };
    angles
        && light.position.is_finite()
        && light.direction.is_finite()
        && light.intensity.is_finite()
        && !light.range.is_nan()
}
