//! The environment as the one sky of the app, so that whoever solves indirect light counts it once.

use std::f64::consts::PI;

use bevy::{
    asset::RenderAssetUsages,
    math::DVec3,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
    tasks::{AsyncComputeTaskPool, Task, futures::check_ready},
};
use farlight_core::{DirectSky, SkyRadiance, SkySource};
use farlight_environment::Environment;

use crate::{
    EnvironmentMap, ProgressiveLighting,
    lights::Group,
    status::{EnvironmentState, EnvironmentStatus},
};

/// Under this name the sky is claimed.
const OWNER: &str = "farlight_ibl";
/// Most columns of the sky's image: indirect light sees no finer detail.
const WIDTH: usize = 512;

/// The map as an image for solvers.
#[derive(Resource, Default)]
pub(crate) struct SkyImage {
    map: Option<AssetId<EnvironmentMap>>,
    task: Option<Task<Image>>,
    image: Option<Handle<Image>>,
}

/// Claims the sky for the environment whose lights shine. They show what comes straight from it; where
/// none shines (there is no camera for them, or no place among the game's own lights), solvers do.
pub(crate) fn claim(
    settings: Res<ProgressiveLighting>,
    status: Res<EnvironmentStatus>,
    group: Res<Group>,
    maps: Res<Assets<EnvironmentMap>>,
    mut events: MessageReader<AssetEvent<EnvironmentMap>>,
    mut sky: ResMut<SkyImage>,
    mut images: ResMut<Assets<Image>>,
    mut source: ResMut<SkySource>,
) {
    let Some(handle) = settings.environment.as_ref().filter(|_| settings.enabled) else {
        events.clear();
        if source.owner() == Some(OWNER) {
            let black = SkyRadiance::Constant(Vec3::ZERO);
            give(&mut source, black, DirectSky::Solved);
            SkySource::release(&mut source, OWNER);
        }
        *sky = SkyImage::default();
        return;
    };
    let id = handle.id();
    let anew = events.read().any(|event| event.is_modified(id) || event.is_added(id));
    if let Some(map) = maps.get(id)
        && (anew || sky.map != Some(id))
    {
        let map = map.0.clone();
        sky.map = Some(id);
        sky.task = Some(AsyncComputeTaskPool::get().spawn(async move { image(&map) }));
    }
    // Until the lights of a new map are chosen those of the old one shine.
    if status.state != EnvironmentState::Ready {
        return;
    }
    if let Some(task) = &mut sky.task
        && let Some(image) = check_ready(task)
    {
        sky.task = None;
        sky.image = Some(images.add(image));
    }
    let Some(image) = &sky.image else { return };
    let radiance = SkyRadiance::Equirect {
        image: image.clone(),
        rotation: settings.rotation,
        brightness: settings.brightness.max(0.0),
    };
    let direct = if group.cycle > 0 { DirectSky::ByLights } else { DirectSky::Solved };
    give(&mut source, radiance, direct);
}

fn give(source: &mut ResMut<SkySource>, radiance: SkyRadiance, direct: DirectSky) {
    if let Err(taken) = SkySource::claim(source, OWNER, radiance, direct) {
        warn_once!("indirect light doesn't know the environment: {taken}");
    }
}

/// The map's radiance, averaged down by solid angle; on the CPU alone.
fn image(map: &Environment) -> Image {
    let (width, height) = (map.width() as usize, map.height() as usize);
    let factor = width.div_ceil(WIDTH).max(1);
    let (columns, rows) = (width.div_ceil(factor), height.div_ceil(factor));
    let cos = |row: usize| (PI * row as f64 / height as f64).cos();
    let mut data = Vec::with_capacity(columns * rows * 16);
    for y in 0..rows {
        for x in 0..columns {
            let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
            for row in y * factor..((y + 1) * factor).min(height) {
                let solid = cos(row) - cos(row + 1);
                let across = x * factor..((x + 1) * factor).min(width);
                for texel in &map.texels()[row * width..][across] {
                    sum += texel.as_dvec3() * solid;
                    weight += solid;
                }
            }
            let mean = (sum / weight).as_vec3();
            data.extend([mean.x, mean.y, mean.z, 1.0].into_iter().flat_map(f32::to_ne_bytes));
        }
    }
    Image::new(
        Extent3d { width: columns as u32, height: rows as u32, depth_or_array_layers: 1 },
        TextureDimension::D2,
        data,
        TextureFormat::Rgba32Float,
        RenderAssetUsages::MAIN_WORLD,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_that_is_averaged_down_keeps_the_flux() {
        let (width, height) = (1200, 601);
        let spot = |i: u32| if i.is_multiple_of(1201) { 5e3 } else { 0.0 };
        let texel = |i: u32| Vec3::new((i % 7) as f32, spot(i), 1.0);
        let map = (0..width * height).map(texel).collect();
        let map = Environment::from_equirect(width, height, map).unwrap();
        let image = image(&map);
        assert!(image.width() <= WIDTH as u32 && image.height() * 2 <= image.width() + 2);
        // Texels are of one size here but for the last row and column, so their bands are taken.
        let (mut flux, mut seen) = (DVec3::ZERO, DVec3::ZERO);
        let solid = |top: u32, bottom: u32| {
            let cos = |row: u32| (PI * f64::from(row.min(height)) / f64::from(height)).cos();
            cos(top) - cos(bottom)
        };
        for y in 0..height {
            for x in 0..width {
                flux += map.texels()[(y * width + x) as usize].as_dvec3() * solid(y, y + 1);
            }
        }
        for y in 0..image.height() {
            for x in 0..image.width() {
                let columns = f64::from((x * 3 + 3).min(width) - x * 3);
                let color = image.get_color_at(x, y).unwrap().to_linear().to_vec3().as_dvec3();
                seen += color * columns * solid(y * 3, y * 3 + 3);
            }
        }
        assert!((seen / flux - 1.0).abs().max_element() < 1e-4, "{seen} {flux}");
    }
}
