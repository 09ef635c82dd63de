//! Views of the lighting itself.

use bevy::{
    camera::visibility::RenderLayers,
    ecs::entity::EntityHashMap,
    light::{AmbientLight, NotShadowCaster},
    pbr::Lightmap,
    prelude::*,
};

use crate::{GiDynamic, GiLightmaps, GiView};

/// A white copy of a lightmapped mesh.
#[derive(Component)]
pub(crate) struct GiTwin;

/// What a camera was before it was switched to the copies.
#[derive(Component)]
pub(crate) struct GiViewed {
    layers: Option<RenderLayers>,
    ambient: Option<AmbientLight>,
}

/// Makes and removes the white copies, and switches cameras between them and the scene.
pub(crate) fn switch_views(
    mut commands: Commands,
    view: Res<GiView>,
    lightmaps: Res<GiLightmaps>,
    lit: Query<(&Mesh3d, &Lightmap)>,
    twins: Query<Entity, With<GiTwin>>,
    cameras: Query<
        (Entity, Option<&RenderLayers>, Option<&AmbientLight>),
        (With<Camera3d>, Without<GiViewed>),
    >,
    viewed: Query<(Entity, &GiViewed)>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut white: Local<Option<Handle<StandardMaterial>>>,
    mut shown: Local<EntityHashMap<Entity>>,
) {
    let layer = RenderLayers::layer(GiView::LAYER);
    if *view != GiView::LightmapOnly {
        if !twins.is_empty() || !viewed.is_empty() {
            for twin in &twins {
                commands.entity(twin).try_despawn();
            }
            for (camera, before) in &viewed {
                let mut camera = commands.entity(camera);
                camera.remove::<GiViewed>();
                match &before.layers {
                    Some(layers) => camera.insert(layers.clone()),
                    None => camera.remove::<RenderLayers>(),
                };
                match &before.ambient {
                    Some(ambient) => camera.insert(ambient.clone()),
                    None => camera.remove::<AmbientLight>(),
                };
            }
            shown.clear();
        }
        return;
    }

    let white = white.get_or_insert_with(|| {
        materials.add(StandardMaterial {
            base_color: Color::WHITE,
            perceptual_roughness: 1.0,
            metallic: 0.0,
            reflectance: 0.0,
            ..default()
        })
    });
    // A mesh whose lightmap moved or went, or that was despawned, loses its copy.
    shown.retain(|&entity, &mut twin| {
        let keep = twins.contains(twin) && lightmaps.placement(entity).is_some();
        if !keep && twins.contains(twin) {
            commands.entity(twin).try_despawn();
        }
        keep
    });
    for (entity, _) in lightmaps.placements() {
        if shown.contains_key(&entity) {
            continue;
        }
        let Ok((mesh, lightmap)) = lit.get(entity) else { continue };
        let twin = commands
            .spawn((
                GiTwin,
                GiDynamic,
                NotShadowCaster,
                mesh.clone(),
                MeshMaterial3d(white.clone()),
                lightmap.clone(),
                layer.clone(),
                ChildOf(entity),
            ))
            .id();
        shown.insert(entity, twin);
    }
    for (camera, layers, ambient) in &cameras {
        // Bevy's ambient light would add to the lightmaps; a camera's own overrides it.
        let none = AmbientLight { brightness: 0.0, ..default() };
        commands.entity(camera).insert((
            GiViewed { layers: layers.cloned(), ambient: ambient.cloned() },
            layer.clone(),
            none,
        ));
    }
}
