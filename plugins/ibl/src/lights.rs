//! A group of the environment's lights as directional lights of Bevy.
//!
//! # Why real lights
//! Bevy's shaders fix the lights that they loop over, so only Bevy's own lights reach every material:
//! `StandardMaterial`, its extensions, a game's own shaders and our loop in `shaders/lighting/`. The
//! price is Bevy's bound of ten directional lights (one on WebGL2): the game's own come first, the
//! group shrinks to what is left, and [`EnvironmentStatus`](crate::EnvironmentStatus) says so. Cameras
//! that don't refine don't see the group (see `layers.rs`).

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
    groups::Arranged,
    settings::{LIGHTS, PER_FRAME},
    status::EnvironmentStatus,
};

/// Beyond everything: one cascade reaches as far as there are shadows.
const FAR: f32 = 1.0e6;

/// A light of the group.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct GroupLight {
    /// Its place in the group.
    at: usize,
    /// Which of all lights shines there.
    pub(crate) light: usize,
}

/// Which group shines.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Group {
    /// Counts up, one a frame that is drawn; its remainder names the group.
    pub(crate) turn: u64,
    /// Groups a cycle; 0: there is no light.
    pub(crate) cycle: u32,
    /// Whether the next frame takes the next group.
    pub(crate) advance: bool,
    /// How many cycles a refined picture has; shadow maps are shifted differently in each of them.
    pub(crate) rounds: u32,
}

impl Group {
    /// The lights of the group that shines: at most one more than in any other group.
    pub(crate) fn range(&self, lights: usize) -> std::ops::Range<usize> {
        let cycle = u64::from(self.cycle.max(1));
        let at = self.turn % cycle;
        let edge = |i: u64| (i * lights as u64 / cycle) as usize;
        edge(at)..edge(at + 1)
    }

    /// Which of the rounds this is. Any run of `rounds` cycles has each of them once for each light.
    pub(crate) fn round(&self) -> u32 {
        (self.turn / u64::from(self.cycle.max(1)) % u64::from(self.rounds.max(1))) as u32
    }
}

/// The game's own directional lights.
pub(crate) type OwnLights<'w, 's> = Query<
    'w,
    's,
    (Entity, Option<&'static RenderLayers>),
    (With<DirectionalLight>, Without<GroupLight>),
>;

/// The most own lights that shine for a refining camera.
fn most_own<'a>(
    own: &OwnLights,
    cameras: impl Iterator<Item = &'a RenderLayers>,
    shines: impl Fn(Entity) -> bool,
) -> usize {
    let own: Vec<_> =
        own.iter().filter(|(light, _)| shines(*light)).map(|(_, layers)| layers).collect();
    let seen = |camera: &RenderLayers| {
        own.iter().filter(|layers| layers.unwrap_or_default().intersects(camera)).count()
    };
    cameras.map(seen).max().unwrap_or(0)
}

/// Whether an entity is visible, before Bevy has propagated that: what becomes visible in this frame
/// needs its place in this frame.
fn is_visible(mut entity: Entity, all: &Query<(&Visibility, Option<&ChildOf>)>) -> bool {
    while let Ok((visibility, parent)) = all.get(entity) {
        match (visibility, parent) {
            (Visibility::Hidden, _) => return false,
            (Visibility::Visible, _) | (Visibility::Inherited, None) => return true,
            (Visibility::Inherited, Some(parent)) => entity = parent.parent(),
        }
    }
    true
}

/// Lets the group of this frame shine.
pub(crate) fn shine(
    mut commands: Commands,
    settings: Res<ProgressiveLighting>,
    set: Res<Lights>,
    mut group: ResMut<Group>,
    mut arranged: ResMut<Arranged>,
    mut status: ResMut<EnvironmentStatus>,
    own: OwnLights,
    cameras: Query<(&Camera, &ProgressiveCamera, Option<&RenderLayers>)>,
    mut visibility: ParamSet<(
        Query<(&Visibility, Option<&ChildOf>)>,
        Query<&mut Visibility, With<GroupLight>>,
    )>,
    mut lights: Query<
        (Entity, &mut GroupLight, &mut DirectionalLight, &mut Transform, &mut RenderLayers),
        Without<ProgressiveCamera>,
    >,
) {
    let active = || cameras.iter().filter(|(camera, ..)| camera.is_active);
    let views = || active().map(|(.., layers)| layers.unwrap_or_default());
    let layers = views().cloned().reduce(|all, layers| all.union(&layers));
    let most = {
        let all = visibility.p0();
        most_own(&own, views(), |light| is_visible(light, &all))
    };
    let places = MAX_DIRECTIONAL_LIGHTS.saturating_sub(most);
    let asked = settings.per_frame.clamp(*PER_FRAME.start(), *PER_FRAME.end());
    let per_frame = (asked as usize).min(places).min(set.0.len());
    let cycle = if settings.enabled && per_frame > 0 && layers.is_some() {
        set.0.len().div_ceil(per_frame) as u32
    } else {
        0
    };
    let crowded_out =
        settings.enabled && per_frame < (asked as usize).min(set.0.len()) && layers.is_some();
    if crowded_out {
        warn_once!(
            "Bevy draws {MAX_DIRECTIONAL_LIGHTS} directional lights: beside {most} of the game, \
             {per_frame} of the environment shine in a frame, not {asked}"
        );
    }
    status.set_if_neq(EnvironmentStatus {
        lights: set.0.len() as u32,
        per_frame: if cycle > 0 { per_frame as u32 } else { 0 },
        crowded_out,
        ..status.clone()
    });
    group.rounds = active().map(|(_, camera, _)| camera.rounds(cycle)).max().unwrap_or(1);
    if group.cycle != cycle {
        *group = Group { turn: 0, cycle, advance: false, rounds: group.rounds };
    } else if group.advance {
        group.turn += 1;
        group.advance = false;
    }
    debug_assert!(set.0.len() <= *LIGHTS.end() as usize);

    let shining = if cycle > 0 { group.range(set.0.len()) } else { 0..0 };
    let shown = if cycle > 0 { Visibility::Visible } else { Visibility::Hidden };
    for mut visibility in &mut visibility.p1() {
        visibility.set_if_neq(shown);
    }
    if !arranged.is_of(&set.0, cycle as usize) {
        arranged.arrange(&set.0, cycle as usize);
    }
    let mut there = 0;
    for (entity, mut place, mut light, mut transform, mut light_layers) in &mut lights {
        there += 1;
        if place.at >= per_frame && cycle > 0 {
            commands.entity(entity).despawn();
            continue;
        }
        let Some(from) = shining.clone().nth(place.at) else {
            // A group may have one light less. Its shadow map stays: an array of another size would
            // be another texture, and the shadows of spot lights lie in it, too.
            light.illuminance = 0.0;
            continue;
        };
        place.light = from;
        let one = &arranged.lights()[from];
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
            GroupLight { at: place, light: 0 },
            DerivedLight,
            DirectionalLight { illuminance: 0.0, ..default() },
            CascadeShadowConfig {
                bounds: vec![FAR],
                overlap_proportion: 0.0,
                minimum_distance: 0.0,
            },
            Transform::default(),
            // Seen from the next frame on, when it has its light.
            Visibility::Hidden,
            RenderLayers::default(),
            // An atmosphere would draw a sun for each.
            SunDisk::OFF,
        ));
    }
}
