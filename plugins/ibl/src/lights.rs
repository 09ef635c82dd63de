//! A group of the environment's lights as directional lights of Bevy.
//!
//! # Why real lights
//! Bevy's shaders fix the lights that they loop over, so only Bevy's own lights reach every material:
//! `StandardMaterial`, its extensions, a game's own shaders and our loop in `shaders/lighting/`. The
//! price is Bevy's bound of ten directional lights (one on WebGL2): the game's own come first, the
//! group shrinks to what is left, and [`EnvironmentStatus`](crate::EnvironmentStatus) says so.

use bevy::{
    camera::visibility::RenderLayers,
    light::{CascadeShadowConfig, SunDisk},
    pbr::MAX_DIRECTIONAL_LIGHTS,
    prelude::*,
};
use farlight_core::DerivedLight;

use crate::{
    ProgressiveCamera, ProgressiveLighting,
    environment::Lights,
    settings::{LIGHTS, PER_FRAME},
    status::EnvironmentStatus,
};

/// Beyond everything: one cascade reaches as far as there are shadows.
const FAR: f32 = 1.0e6;

/// The place of a light in its group.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct GroupLight(usize);

/// Which group shines.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Group {
    /// Counts up, one a frame that is drawn; its remainder names the group.
    pub(crate) turn: u64,
    /// Groups a cycle; 0: there is no light.
    pub(crate) cycle: u32,
    /// Whether the next frame takes the next group.
    pub(crate) advance: bool,
}

impl Group {
    /// The lights of the group that shines: at most one more than in any other group.
    pub(crate) fn range(&self, lights: usize) -> std::ops::Range<usize> {
        let cycle = u64::from(self.cycle.max(1));
        let at = self.turn % cycle;
        let edge = |i: u64| (i * lights as u64 / cycle) as usize;
        edge(at)..edge(at + 1)
    }
}

/// Lets the group of this frame shine.
pub(crate) fn shine(
    mut commands: Commands,
    settings: Res<ProgressiveLighting>,
    set: Res<Lights>,
    mut group: ResMut<Group>,
    mut status: ResMut<EnvironmentStatus>,
    others: Query<&ViewVisibility, (With<DirectionalLight>, Without<GroupLight>)>,
    cameras: Query<(&Camera, Option<&RenderLayers>), With<ProgressiveCamera>>,
    mut lights: Query<
        (
            Entity,
            &GroupLight,
            &mut DirectionalLight,
            &mut Transform,
            &mut Visibility,
            &mut RenderLayers,
        ),
        Without<ProgressiveCamera>,
    >,
) {
    let seen = cameras.iter().filter(|(camera, _)| camera.is_active);
    let layers = seen.fold(None, |all: Option<RenderLayers>, (_, layers)| {
        let layers = layers.cloned().unwrap_or_default();
        Some(all.map_or(layers.clone(), |all| all.union(&layers)))
    });
    let places = MAX_DIRECTIONAL_LIGHTS.saturating_sub(others.iter().len());
    let asked = settings.per_frame.clamp(*PER_FRAME.start(), *PER_FRAME.end());
    let per_frame = (asked as usize).min(places).min(set.0.len());
    let cycle = if settings.enabled && per_frame > 0 && layers.is_some() {
        set.0.len().div_ceil(per_frame) as u32
    } else {
        0
    };
    status.per_frame = if cycle > 0 { per_frame as u32 } else { 0 };
    status.lights = set.0.len() as u32;
    status.crowded_out = settings.enabled
        && !set.0.is_empty()
        && per_frame < asked as usize
        && (asked as usize) <= set.0.len();
    if group.cycle != cycle {
        *group = Group { turn: 0, cycle, advance: false };
    } else if group.advance {
        group.turn += 1;
        group.advance = false;
    }
    debug_assert!(set.0.len() <= *LIGHTS.end() as usize);

    let shining = if cycle > 0 { group.range(set.0.len()) } else { 0..0 };
    let mut there = 0;
    for (entity, place, mut light, mut transform, mut visibility, mut light_layers) in &mut lights {
        there += 1;
        if place.0 >= per_frame && cycle > 0 {
            commands.entity(entity).despawn();
            continue;
        }
        let Some(from) = shining.clone().nth(place.0) else {
            visibility.set_if_neq(Visibility::Hidden);
            continue;
        };
        visibility.set_if_neq(Visibility::Visible);
        let one = &set.0[from];
        let irradiance = one.irradiance * (settings.brightness.max(0.0) * cycle as f32);
        let strongest = irradiance.max_element();
        let tint = if strongest > 0.0 { irradiance / strongest } else { Vec3::ONE };
        light.color = Color::linear_rgb(tint.x, tint.y, tint.z);
        light.illuminance = strongest;
        light.shadow_maps_enabled = settings.shadows;
        let direction = settings.rotation * one.direction;
        let up = if direction.y.abs() > 0.99 { Vec3::X } else { Vec3::Y };
        *transform = Transform::default().looking_to(-direction, up);
        if let Some(layers) = &layers {
            light_layers.set_if_neq(layers.clone());
        }
    }
    for place in there..if cycle > 0 { per_frame } else { 0 } {
        commands.spawn((
            Name::new("environment light"),
            GroupLight(place),
            DerivedLight,
            DirectionalLight { illuminance: 0.0, ..default() },
            CascadeShadowConfig {
                bounds: vec![FAR],
                overlap_proportion: 0.0,
                minimum_distance: 0.0,
            },
            Transform::default(),
            Visibility::Hidden,
            RenderLayers::default(),
            // An atmosphere would draw a sun for each.
            SunDisk::OFF,
        ));
    }
}
