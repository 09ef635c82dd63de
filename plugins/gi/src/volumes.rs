//! Bevy's irradiance volumes, filled from probe grids.

use bevy::{
    asset::RenderAssetUsages,
    ecs::entity::EntityHashMap,
    image::ImageSampler,
    light::IrradianceVolume,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use farlight_core::{Region, RegionProblem, TextureUploads, Ticket};

use crate::{EncodedGrid, GiProbeVolume};

/// The textures of the probe volumes.
#[derive(Resource, Default)]
pub(crate) struct Volumes {
    volumes: EntityHashMap<Volume>,
}

struct Volume {
    image: Handle<Image>,
    resolution: UVec3,
    texels: Vec<u8>,
}

impl Volumes {
    /// Sends a grid's ambient cubes on their way to the GPU. The first ones make the texture and
    /// Bevy's component; a changed resolution makes a new texture.
    pub(crate) fn write(
        &mut self,
        entity: Entity,
        grid: EncodedGrid,
        shown: bool,
        commands: &mut Commands,
        images: &mut Assets<Image>,
        uploads: &TextureUploads,
    ) -> Result<Option<Ticket>, RegionProblem> {
        let size = grid.resolution * UVec3::new(1, 2, 3);
        if grid.texels.is_empty() || grid.texels.len() != size.element_product() as usize * 8 {
            warn!("probes that don't fill their grid are ignored");
            return Ok(None);
        }
        let known = self.volumes.get(&entity).is_some_and(|v| v.resolution == grid.resolution);
        if !known {
            let image = images.add(volume_image(size));
            commands.entity(entity).try_insert(IrradianceVolume {
                voxels: image.clone(),
                intensity: intensity(shown),
                affects_lightmapped_meshes: false,
            });
            let volume = Volume { image, resolution: grid.resolution, texels: Vec::new() };
            if let Some(old) = self.volumes.insert(entity, volume) {
                uploads.forget(old.image.id());
            }
        }
        let Some(volume) = self.volumes.get_mut(&entity) else { return Ok(None) };
        volume.texels.clone_from(&grid.texels);
        uploads
            .write(volume.image.id(), Region { origin: UVec3::ZERO, size }, grid.texels)
            .map(Some)
    }

    /// Writes all volumes, for example into new textures.
    pub(crate) fn write_all(&self, uploads: &TextureUploads) {
        for volume in self.volumes.values() {
            let size = volume.resolution * UVec3::new(1, 2, 3);
            let region = Region { origin: UVec3::ZERO, size };
            if let Err(problem) = uploads.write(volume.image.id(), region, volume.texels.clone()) {
                warn!("a probe volume can't be written: {problem}");
            }
        }
    }

    /// Forgets a volume.
    pub(crate) fn remove(
        &mut self,
        entity: Entity,
        commands: &mut Commands,
        uploads: &TextureUploads,
    ) {
        if let Some(volume) = self.volumes.remove(&entity) {
            uploads.forget(volume.image.id());
            if let Ok(mut entity) = commands.get_entity(entity) {
                entity.try_remove::<IrradianceVolume>();
            }
        }
    }
}

/// Voxels hold E / π in cd/m², what Bevy multiplies with the diffuse colour.
fn intensity(shown: bool) -> f32 {
    if shown { 1.0 } else { 0.0 }
}

/// Switches volumes with the lightmaps. Bevy gathers volumes every frame, so this is at once. Answers
/// whether any changed.
pub(crate) fn show_volumes(
    shown: bool,
    volumes: &mut Query<&mut IrradianceVolume, With<GiProbeVolume>>,
) -> bool {
    let mut changed = false;
    for mut volume in volumes {
        if volume.intensity != intensity(shown) {
            volume.intensity = intensity(shown);
            changed = true;
        }
    }
    changed
}

fn volume_image(size: UVec3) -> Image {
    let mut image = Image::new_uninit(
        Extent3d { width: size.x, height: size.y, depth_or_array_layers: size.z },
        TextureDimension::D3,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.label = Some("farlight probe volume");
    image.sampler = ImageSampler::linear();
    image
}
