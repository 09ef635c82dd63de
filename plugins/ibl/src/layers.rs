//! Only refining cameras see the environment's lights.
//!
//! A camera that doesn't refine, such as a minimap's, would flicker: a few lights shine in a frame,
//! and as brightly as all together. Bevy tells lights and cameras apart by `RenderLayers`, which
//! belong to the game, so the lights get a layer of their own for as long as Bevy looks up which
//! camera sees which light, and only in the render world. What casts shadows for whom stays the
//! game's choice: the shadow map of a camera shows what is on the camera's layers.

use bevy::{
    camera::visibility::RenderLayers,
    ecs::entity::EntityHashMap,
    pbr::{
        ExtractedDirectionalLight, LightEntity, MAX_DIRECTIONAL_LIGHTS, ViewLightEntities,
        prepare_lights,
    },
    prelude::*,
    render::{
        Extract, ExtractSchedule, Render, RenderSystems,
        camera::{DirtySpecializations, ExtractedCamera},
        sync_world::RenderEntity,
        view::ExtractedView,
    },
};

use crate::{ProgressiveCamera, lights::GroupLight};

/// Far beyond the layers of any game.
const LAYER: usize = 511;

/// The environment's lights and the cameras that see them, in the render world.
#[derive(Resource, Default)]
struct Separated {
    lights: Vec<Entity>,
    views: Vec<Entity>,
    /// What the game says.
    layers: EntityHashMap<Option<RenderLayers>>,
    /// What cameras had in the frame before.
    before: EntityHashMap<RenderLayers>,
}

pub(crate) fn build(render_app: &mut SubApp) {
    render_app.init_resource::<Separated>().add_systems(ExtractSchedule, extract).add_systems(
        Render,
        (separate.before(prepare_lights), restore.after(prepare_lights))
            .in_set(RenderSystems::CreateViews),
    );
}

fn extract(
    lights: Extract<Query<RenderEntity, With<GroupLight>>>,
    views: Extract<Query<RenderEntity, With<ProgressiveCamera>>>,
    mut separated: ResMut<Separated>,
) {
    separated.lights.clear();
    separated.lights.extend(&lights);
    separated.views.clear();
    separated.views.extend(&views);
}

/// Gives the lights and their cameras a layer of their own.
fn separate(world: &mut World) {
    world.resource_scope(|world, mut separated: Mut<Separated>| {
        let separated = &mut *separated;
        separated.layers.clear();
        separated.lights.retain(|light| world.get::<ExtractedDirectionalLight>(*light).is_some());
        separated.lights.sort_unstable();
        // A camera that became one only after shadow maps were fitted has none yet.
        let has_maps = |world: &World, view: Entity| {
            separated.lights.iter().all(|light| {
                world.get::<ExtractedDirectionalLight>(*light).is_some_and(|light| {
                    !light.shadow_maps_enabled || light.cascades.contains_key(&view)
                })
            })
        };
        separated
            .views
            .retain(|view| world.get::<ExtractedCamera>(*view).is_some() && has_maps(world, *view));
        let places = places(world, separated);
        for (index, light) in separated.lights.iter().enumerate() {
            let layers = if index < places {
                RenderLayers::none().with(LAYER)
            } else {
                RenderLayers::none()
            };
            separated.layers.insert(*light, replace(world, *light, Some(layers)));
        }
        for view in &separated.views {
            let layers = world.get::<RenderLayers>(*view).cloned().unwrap_or_default();
            separated.layers.insert(*view, replace(world, *view, Some(layers.with(LAYER))));
        }
        scatter(world, &separated.lights);
    });
}

/// Where one of the game's lights scatters in fog, the environment's do so, too. Bevy sorts scattering
/// lights last, but has only the first ones scatter, as many as there are: beside lights that don't,
/// the game's would lose its beams.
fn scatter(world: &mut World, lights: &[Entity]) {
    let mut all = world.query::<(Entity, &ExtractedDirectionalLight)>();
    let scatters = all
        .iter(world)
        .any(|(entity, light)| light.volumetric && lights.binary_search(&entity).is_err());
    for light in lights {
        if let Some(mut light) = world.get_mut::<ExtractedDirectionalLight>(*light) {
            light.volumetric = scatters;
        }
    }
}

/// How many lights have places beside the game's own, also of those that appeared in this very frame.
fn places(world: &mut World, separated: &Separated) -> usize {
    let mut all =
        world.query_filtered::<(Entity, Option<&RenderLayers>), With<ExtractedDirectionalLight>>();
    let own: Vec<_> = all
        .iter(world)
        .filter(|(entity, _)| separated.lights.binary_search(entity).is_err())
        .map(|(_, layers)| layers.cloned().unwrap_or_default())
        .collect();
    let seen = |view: &Entity| {
        let layers = world.get::<RenderLayers>(*view).cloned().unwrap_or_default();
        own.iter().filter(|own| own.intersects(&layers)).count()
    };
    let most = separated.views.iter().map(seen).max().unwrap_or(0);
    MAX_DIRECTIONAL_LIGHTS.saturating_sub(most)
}

/// Gives the layers back, and to each shadow map of these lights those of its camera.
fn restore(world: &mut World) {
    world.resource_scope(|world, mut separated: Mut<Separated>| {
        let separated = &mut *separated;
        for (entity, layers) in separated.layers.drain() {
            replace(world, entity, layers);
        }
        let mut before = std::mem::take(&mut separated.before);
        for view in &separated.views {
            let layers = world.get::<RenderLayers>(*view).cloned().unwrap_or_default();
            let known = before.remove(view);
            let others = known.is_some_and(|known| known != layers);
            let maps = world.get::<ViewLightEntities>(*view).map(|maps| maps.lights.clone());
            for map in maps.into_iter().flatten() {
                let light = match world.get::<LightEntity>(map) {
                    Some(LightEntity::Directional { light_entity, .. }) => *light_entity,
                    _ => continue,
                };
                if separated.lights.binary_search(&light).is_err() {
                    continue;
                }
                replace(world, map, Some(layers.clone()));
                if others && let Some(map) = world.get::<ExtractedView>(map) {
                    // What was sorted by the layers before is sorted anew.
                    let map = map.retained_view_entity;
                    world.resource_mut::<DirtySpecializations>().views.insert(map);
                }
            }
            separated.before.insert(*view, layers);
        }
    });
}

/// Replaces the layers of an entity; returns those before.
fn replace(
    world: &mut World,
    entity: Entity,
    layers: Option<RenderLayers>,
) -> Option<RenderLayers> {
    let mut entity = world.get_entity_mut(entity).ok()?;
    match (entity.get_mut::<RenderLayers>(), layers) {
        (Some(mut there), Some(layers)) => Some(std::mem::replace(&mut *there, layers)),
        (Some(_), None) => entity.take(),
        (None, Some(layers)) => {
            entity.insert(layers);
            None
        }
        (None, None) => None,
    }
}
