//! The environment as it is seen: behind everything, and as Bevy's own image-based light.

use bevy::{
    asset::RenderAssetUsages,
    light::Skybox,
    platform::collections::HashMap,
    prelude::*,
    render::render_resource::{
        Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
    },
    tasks::{AsyncComputeTaskPool, Task, futures::check_ready},
};
use farlight_environment::{CubeMap, Environment};
use half::f16;

use crate::{EnvironmentMap, ProgressiveLighting, lights::Group};

/// Edges of a backdrop; a quarter of the map's width is as sharp as the map.
const BACKDROP: std::ops::RangeInclusive<u32> = 64..=1024;
/// Edge of the mirrored light's cube, and its levels.
const SPECULAR: [u32; 2] = [128, 6];
/// Edge of the diffuse light's cube.
const DIFFUSE: u32 = 16;

/// Shows the environment of [`ProgressiveLighting`] behind all that a camera sees, as a [`Skybox`] that
/// this component makes and keeps in step with the map, its rotation and its brightness. Removing it
/// removes the skybox.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct EnvironmentBackdrop {
    /// Multiplies what is seen of the map, 0 or more; its light stays as it is.
    pub brightness: f32,
}

impl Default for EnvironmentBackdrop {
    fn default() -> Self {
        Self { brightness: 1.0 }
    }
}

/// Lights what a camera sees with Bevy's image-based light ([`EnvironmentMapLight`], without shadows)
/// while the directional lights of [`ProgressiveLighting`] don't shine: before they are chosen, where
/// they are switched off or the game's own lights have all the places. Light is never counted twice.
///
/// The `EnvironmentMapLight` is made by this component of the same map; removing it removes that.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct ImageBasedFallback;

/// What cube maps are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Purpose {
    Backdrop,
    /// Diffuse and mirrored light.
    Light,
}

/// Cube maps of environments that were shown and are still loaded.
#[derive(Resource, Default)]
pub(crate) struct Cubes(HashMap<(AssetId<EnvironmentMap>, Purpose), Made>);

#[derive(Default)]
struct Made {
    task: Option<Task<Vec<Image>>>,
    images: Vec<Handle<Image>>,
}

/// Has cube maps made that are asked for, and takes those that are done.
fn update(
    cubes: &mut Cubes,
    asked: (AssetId<EnvironmentMap>, Purpose),
    maps: &Assets<EnvironmentMap>,
    images: &mut Assets<Image>,
) {
    if !cubes.0.contains_key(&asked)
        && let Some(map) = maps.get(asked.0)
    {
        let task = Some(make(map.clone(), asked.1));
        cubes.0.insert(asked, Made { task, images: Vec::new() });
    }
    let Some(made) = cubes.0.get_mut(&asked) else { return };
    if let Some(done) = made.task.as_mut().and_then(check_ready) {
        made.task = None;
        made.images = done.into_iter().map(|image| images.add(image)).collect();
    }
}

fn make(map: EnvironmentMap, purpose: Purpose) -> Task<Vec<Image>> {
    AsyncComputeTaskPool::get().spawn(async move {
        let map: &Environment = &map.0;
        match purpose {
            Purpose::Backdrop => {
                let edge = (map.width() / 4).max(1).next_power_of_two();
                vec![image(&map.cube(edge.clamp(*BACKDROP.start(), *BACKDROP.end())))]
            }
            Purpose::Light => {
                let [edge, levels] = SPECULAR;
                vec![image(&map.diffuse_cube(DIFFUSE)), image(&map.specular_cube(edge, levels))]
            }
        }
    })
}

/// A cube as Bevy draws it. Values above those that half floats hold are cut off.
fn image(cube: &CubeMap) -> Image {
    let mut data = Vec::with_capacity(cube.texels.len() * 8);
    for texel in &cube.texels {
        for value in texel.min(Vec3::splat(60_000.0)).extend(1.0).to_array() {
            data.extend(f16::from_f32(value).to_le_bytes());
        }
    }
    let mut image = Image::new_uninit(
        Extent3d { width: cube.edge, height: cube.edge, depth_or_array_layers: 6 },
        TextureDimension::D2,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.mip_level_count = cube.levels;
    image.texture_view_descriptor =
        Some(TextureViewDescriptor { dimension: Some(TextureViewDimension::Cube), ..default() });
    image.data = Some(data);
    image
}

/// Forgets cube maps of maps that are gone; makes those anew that changed.
pub(crate) fn forget(
    mut events: MessageReader<AssetEvent<EnvironmentMap>>,
    maps: Res<Assets<EnvironmentMap>>,
    mut cubes: ResMut<Cubes>,
) {
    for event in events.read() {
        match event {
            AssetEvent::Removed { id } => cubes.0.retain(|(map, _), _| map != id),
            AssetEvent::Modified { id } => {
                let Some(map) = maps.get(*id) else { continue };
                for ((_, purpose), made) in cubes.0.iter_mut().filter(|((of, _), _)| of == id) {
                    made.task = Some(make(map.clone(), *purpose));
                }
            }
            _ => {}
        }
    }
}

/// Keeps the skyboxes of cameras in step.
pub(crate) fn show_backdrops(
    mut commands: Commands,
    settings: Res<ProgressiveLighting>,
    maps: Res<Assets<EnvironmentMap>>,
    mut images: ResMut<Assets<Image>>,
    mut cubes: ResMut<Cubes>,
    mut cameras: Query<(Entity, &EnvironmentBackdrop, Option<&mut Skybox>)>,
    mut removed: RemovedComponents<EnvironmentBackdrop>,
) {
    for entity in removed.read().filter(|entity| !cameras.contains(*entity)) {
        if let Ok(mut camera) = commands.get_entity(entity) {
            camera.try_remove::<Skybox>();
        }
    }
    if cameras.is_empty() {
        return;
    }
    let map = settings.environment.as_ref().map(|map| (map.id(), Purpose::Backdrop));
    if let Some(asked) = map {
        update(&mut cubes, asked, &maps, &mut images);
    }
    let made = map.and_then(|asked| cubes.0.get(&asked));
    let image = made.and_then(|made| made.images.first());
    for (entity, backdrop, skybox) in &mut cameras {
        let Some(image) = image else {
            // Until a new one is there, the one before is seen.
            if map.is_none() {
                commands.entity(entity).remove::<Skybox>();
            }
            continue;
        };
        let wanted = Skybox {
            image: Some(image.clone()),
            brightness: settings.brightness.max(0.0) * backdrop.brightness.max(0.0),
            rotation: settings.rotation,
        };
        match skybox {
            None => {
                commands.entity(entity).insert(wanted);
            }
            Some(mut old) => {
                let same = old.image == wanted.image
                    && old.brightness == wanted.brightness
                    && old.rotation == wanted.rotation;
                if !same {
                    *old = wanted;
                }
            }
        }
    }
}

/// Switches image-based light on where the directional lights don't shine, and off where they do.
pub(crate) fn fall_back(
    mut commands: Commands,
    settings: Res<ProgressiveLighting>,
    group: Res<Group>,
    maps: Res<Assets<EnvironmentMap>>,
    mut images: ResMut<Assets<Image>>,
    mut cubes: ResMut<Cubes>,
    mut cameras: Query<(Entity, Option<&mut EnvironmentMapLight>), With<ImageBasedFallback>>,
    mut removed: RemovedComponents<ImageBasedFallback>,
) {
    for entity in removed.read().filter(|entity| !cameras.contains(*entity)) {
        if let Ok(mut camera) = commands.get_entity(entity) {
            camera.try_remove::<EnvironmentMapLight>();
        }
    }
    if cameras.is_empty() {
        return;
    }
    let map = settings.environment.as_ref().map(|map| (map.id(), Purpose::Light));
    if let Some(asked) = map {
        update(&mut cubes, asked, &maps, &mut images);
    }
    let made = map.filter(|_| group.cycle == 0).and_then(|asked| cubes.0.get(&asked));
    let light = match made.map(|made| made.images.as_slice()) {
        Some([diffuse, specular]) => Some(EnvironmentMapLight {
            diffuse_map: diffuse.clone(),
            specular_map: specular.clone(),
            intensity: settings.brightness.max(0.0),
            rotation: settings.rotation,
            ..default()
        }),
        _ => None,
    };
    for (entity, old) in &mut cameras {
        match (&light, old) {
            (Some(wanted), None) => {
                commands.entity(entity).insert(wanted.clone());
            }
            (Some(wanted), Some(mut old)) => {
                let same = old.diffuse_map == wanted.diffuse_map
                    && old.specular_map == wanted.specular_map
                    && old.intensity == wanted.intensity
                    && old.rotation == wanted.rotation;
                if !same {
                    *old = wanted.clone();
                }
            }
            (None, Some(_)) => {
                commands.entity(entity).remove::<EnvironmentMapLight>();
            }
            (None, None) => {}
        }
    }
}
