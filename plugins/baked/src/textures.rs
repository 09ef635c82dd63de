//! The textures that a root shows: those of the manifest, or its own into which scenarios are blended.

use bevy::{
    asset::{LoadState, RenderAssetUsages},
    image::ImageSampler,
    prelude::*,
    render::render_resource::{
        Extent3d, TextureDimension, TextureFormat, TextureSampleType, TextureUsages,
    },
};

use crate::{BakedManifest, blend::Blends};

/// What a root shows.
pub(crate) struct Textures {
    pub(crate) pages: Vec<Shown>,
    pub(crate) volumes: Vec<Shown>,
    /// Whether they are the root's own.
    pub(crate) blended: bool,
    /// Bytes of GPU memory, those of the manifest included.
    pub(crate) bytes: u64,
}

/// A page or a volume.
#[derive(Clone)]
pub(crate) struct Shown {
    /// What is drawn.
    pub(crate) image: Handle<Image>,
    size: UVec3,
    /// The same of each scenario.
    pub(crate) baked: Vec<Handle<Image>>,
    /// Why it can't be shown.
    pub(crate) problem: Option<String>,
}

impl Textures {
    pub(crate) fn all(&self) -> impl Iterator<Item = &Shown> {
        self.pages.iter().chain(&self.volumes)
    }

    /// Those of the manifest, once all are loaded or known to be missing; `None` until then. With
    /// `blend` each is a texture of its own, taken over from `old` where the sizes are the same.
    pub(crate) fn take(
        manifest: &BakedManifest,
        blend: bool,
        old: Option<&Self>,
        server: &AssetServer,
        images: &mut Assets<Image>,
    ) -> Option<Self> {
        let coming = |image: &Handle<Image>| {
            matches!(server.get_load_state(image), Some(LoadState::NotLoaded | LoadState::Loading))
        };
        if manifest.images().any(coming) {
            return None;
        }
        let old = old.filter(|old| old.blended == blend);
        let scenarios = manifest.scenarios.len();
        let edge = manifest.page_size;
        let mut bytes = 0;
        let mut shown = |baked: Vec<Handle<Image>>, size: UVec3, old: Option<&Shown>| {
            let texels = u64::from(size.x) * u64::from(size.y) * u64::from(size.z);
            let problem = baked.iter().find_map(|image| problem(image, size, server, images));
            let sizes = baked.iter().filter_map(|image| images.get(image));
            bytes += sizes.map(|image| image_bytes(image, texels)).sum::<u64>();
            let image = match (&problem, old) {
                (Some(_), _) => Handle::default(),
                (None, _) if !blend => baked[0].clone(),
                (None, Some(old)) if old.size == size && old.problem.is_none() => old.image.clone(),
                _ => images.add(target(size)),
            };
            bytes += if blend && problem.is_none() { 8 * texels } else { 0 };
            Shown { image, size, baked, problem }
        };
        let pages = (0..manifest.pages as usize).map(|page| {
            let baked = (0..scenarios).filter_map(|s| manifest.page(s, page).cloned()).collect();
            let old = old.and_then(|old| old.pages.get(page));
            shown(baked, UVec3::new(edge, edge, 1), old)
        });
        let pages = pages.collect();
        let volumes = manifest.volumes.iter().enumerate().map(|(index, volume)| {
            let baked = (0..scenarios).filter_map(|s| manifest.volume(s, index).cloned()).collect();
            let size = UVec3::from(volume.resolution).saturating_mul(UVec3::new(1, 2, 3));
            shown(baked, size, old.and_then(|old| old.volumes.get(index)))
        });
        let volumes = volumes.collect();
        Some(Self { pages, volumes, blended: blend, bytes })
    }

    /// Orders what has no problem to be blended anew.
    pub(crate) fn blend(&self, weights: &[f32], blends: &Blends) {
        for shown in self.all().filter(|shown| self.blended && shown.problem.is_none()) {
            let inputs = shown.baked.iter().map(Handle::id).zip(weights.iter().copied());
            blends.order(shown.image.id(), shown.size, inputs.filter(|(_, weight)| *weight > 0.0));
        }
    }

    /// Whether some are still to be blended.
    pub(crate) fn are_waiting(&self, blends: &Blends) -> bool {
        self.blended && self.all().any(|shown| blends.is_waiting(shown.image.id()))
    }

    /// Lets go of what `next` doesn't use any more.
    pub(crate) fn forget(&self, next: Option<&Self>, blends: &Blends) {
        for shown in self.all().filter(|_| self.blended) {
            let used = next.is_some_and(|next| next.all().any(|n| n.image == shown.image));
            if !used {
                blends.forget(shown.image.id());
            }
        }
    }
}

/// Why a texture can't be shown as one of `size`.
fn problem(
    image: &Handle<Image>,
    size: UVec3,
    server: &AssetServer,
    images: &Assets<Image>,
) -> Option<String> {
    let file = || server.get_path(image).map_or_else(|| "a texture".into(), |p| p.to_string());
    if let Some(LoadState::Failed(error)) = server.get_load_state(image) {
        let error = error.to_string();
        let error = error.lines().next().unwrap_or_default();
        return Some(format!("{} is not loaded: {error}", file()));
    }
    let Some(loaded) = images.get(image) else {
        return Some(format!("{} is not loaded", file()));
    };
    let texture = &loaded.texture_descriptor;
    let found =
        UVec3::new(texture.size.width, texture.size.height, texture.size.depth_or_array_layers);
    let dimension = if size.z > 1 { TextureDimension::D3 } else { TextureDimension::D2 };
    if found != size || texture.dimension != dimension {
        return Some(format!("{} has {found} texels and not {size}", file()));
    }
    let kind = texture.format.sample_type(None, None);
    if kind != Some(TextureSampleType::Float { filterable: true }) {
        return Some(format!("{} is of {:?}, which can't be filtered", file(), texture.format));
    }
    None
}

/// Bytes of an image with so many texels (a third more with mip levels).
fn image_bytes(image: &Image, texels: u64) -> u64 {
    let format = image.texture_descriptor.format;
    let (width, height) = format.block_dimensions();
    let block = u64::from(format.block_copy_size(None).unwrap_or(16));
    let bytes = texels * block / u64::from(width * height);
    if image.texture_descriptor.mip_level_count > 1 { bytes * 4 / 3 } else { bytes }
}

/// A texture to blend into, black.
fn target(size: UVec3) -> Image {
    let dimension = if size.z > 1 { TextureDimension::D3 } else { TextureDimension::D2 };
    let mut image = Image::new_uninit(
        Extent3d { width: size.x, height: size.y, depth_or_array_layers: size.z },
        dimension,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.label = Some("farlight baked light");
    image.texture_descriptor.usage |= TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
    image.sampler = ImageSampler::linear();
    image
}
