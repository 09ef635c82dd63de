//! Materials and the textures that they use.

use std::{
    collections::{BTreeMap, BTreeSet},
    io::Cursor,
    sync::Arc,
};

use glam::{Affine2, Vec2, Vec3, Vec4};
use gltf::json::{self, material::AlphaMode as JsonAlphaMode, texture::Info, validation::Checked};
use image::{ImageFormat, ImageReader, Limits};

use super::{
    DEFAULT_MATERIAL, ImportLimits, ImportProblem,
    container::File,
    error::{Warnings, label, shorten},
};
use crate::scene::{AlphaMode, Material, MaterialId, Scene, Texture, TextureId};

/// Reads materials that are in use, and each of their images once a colour space.
pub(super) struct Materials<'a> {
    file: &'a File<'a>,
    limits: &'a ImportLimits,
    texels: u64,
    materials: BTreeMap<MaterialId, Material>,
    textures: BTreeMap<TextureId, Arc<Texture>>,
    /// Images that do not decode, so that each is tried and reported once.
    broken: BTreeSet<TextureId>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(file: &'a File<'a>, limits: &'a ImportLimits) -> Self {
        Self {
            file,
            limits,
            texels: 0,
            materials: BTreeMap::new(),
            textures: BTreeMap::new(),
            broken: BTreeSet::new(),
        }
    }

    pub(super) fn finish(self, scene: &mut Scene) {
        scene.materials = self.materials;
        scene.textures = self.textures;
    }

    /// The texture coordinate set that a material's textures are read at: a mesh keeps one.
    pub(super) fn uv_set(&self, material: Option<usize>) -> u32 {
        let info = material.and_then(|m| self.file.root.materials.get(m)).and_then(|m| {
            m.pbr_metallic_roughness.base_color_texture.as_ref().or(m.emissive_texture.as_ref())
        });
        info.map_or(0, |info| placement(info).0)
    }

    /// Reads a material unless it was read.
    pub(super) fn need(
        &mut self,
        index: Option<usize>,
        warnings: &mut Warnings,
    ) -> Result<(), ImportProblem> {
        let id = index.map_or(DEFAULT_MATERIAL, |index| MaterialId(index as u64));
        if self.materials.contains_key(&id) {
            return Ok(());
        }
        let default = json::Material::default();
        let (json, name) = match index {
            None => (&default, String::new()),
            Some(index) => match self.file.root.materials.get(index) {
                Some(json) => (json, label("material", index, json.name.as_deref())),
                None => {
                    return Err(ImportProblem::Damaged(format!(
                        "material {index} does not exist (there are {})",
                        self.file.root.materials.len()
                    )));
                }
            },
        };
        let pbr = &json.pbr_metallic_roughness;
        let mut factor = |what: &str, value: Vec4, high: f32, default: Vec4| {
            if value.is_finite() && value.min_element() >= 0.0 && value.max_element() <= high {
                return value;
            }
            warnings.push(|| format!("{name}: {what} is {value}, not 0 to {high}: it is clamped"));
            if value.is_nan() { default } else { value.clamp(Vec4::ZERO, Vec4::splat(high)) }
        };
        let base_color = factor("base colour", pbr.base_color_factor.0.into(), 1.0, Vec4::ONE);
        let metallic = factor("metallic", Vec4::splat(pbr.metallic_factor.0), 1.0, Vec4::ONE).x;
        let perceptual_roughness =
            factor("roughness", Vec4::splat(pbr.roughness_factor.0), 1.0, Vec4::ONE).x;
        let strength = json
            .extensions
            .as_ref()
            .and_then(|e| e.emissive_strength.as_ref())
            .map_or(1.0, |e| e.emissive_strength.0);
        let emissive = (Vec3::from(json.emissive_factor.0) * strength).extend(0.0);
        let emissive = factor("emission", emissive, f32::MAX, Vec4::ZERO).truncate();
        let alpha_mode = match json.alpha_mode {
            Checked::Valid(JsonAlphaMode::Mask) => {
                AlphaMode::Mask(json.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0))
            }
            Checked::Valid(JsonAlphaMode::Blend) => AlphaMode::Blend,
            _ => AlphaMode::Opaque,
        };
        let base = pbr.base_color_texture.as_ref();
        let emission = json.emissive_texture.as_ref();
        let first = base.or(emission);
        for other in [emission, pbr.metallic_roughness_texture.as_ref()].into_iter().flatten() {
            if first.is_some_and(|first| placement(first) != placement(other)) {
                warnings.push(|| {
                    format!(
                        "{name}: its textures are placed differently, all are read as the first"
                    )
                });
            }
        }
        let uv_transform = first.map_or(Affine2::IDENTITY, |info| placement(info).1);
        let mut texture = |info: Option<&Info>, srgb| match info {
            Some(info) => self.texture(info, srgb, &name, warnings),
            None => Ok(None),
        };
        let material = Material {
            base_color,
            base_color_texture: texture(base, true)?,
            metallic,
            perceptual_roughness,
            metallic_roughness_texture: texture(pbr.metallic_roughness_texture.as_ref(), false)?,
            emissive,
            emissive_texture: texture(emission, true)?,
            alpha_mode,
            double_sided: json.double_sided,
            uv_transform,
            ..Material::default()
        };
        self.materials.insert(id, material);
        Ok(())
    }

    /// The id of a texture's image in a colour space; `None` (with a warning) if it does not decode.
    fn texture(
        &mut self,
        info: &Info,
        srgb: bool,
        material: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<TextureId>, ImportProblem> {
        let root = &self.file.root;
        let Some(texture) = root.get(info.index) else {
            return Err(ImportProblem::Damaged(format!(
                "{material} names texture {}, but there are {}",
                info.index,
                root.textures.len()
            )));
        };
        let index = texture.source.value();
        let id = TextureId((index as u64) << 1 | u64::from(srgb));
        if self.textures.contains_key(&id) {
            return Ok(Some(id));
        }
        if self.broken.contains(&id) {
            return Ok(None);
        }
        let decoded = match root.images.get(index) {
            Some(image) => self.decode(index, image, srgb)?,
            None => Err("its image does not exist or has a format that is not supported".into()),
        };
        match decoded {
            Ok(texture) => {
                self.textures.insert(id, Arc::new(texture));
                Ok(Some(id))
            }
            Err(what) => {
                warnings.push(|| {
                    format!(
                        "{material}, texture {}: {what}; the colour factor is used alone",
                        info.index
                    )
                });
                self.broken.insert(id);
                Ok(None)
            }
        }
    }

    /// Outer error: stop. Inner error: this image is not usable.
    fn decode(
        &mut self,
        index: usize,
        image: &json::Image,
        srgb: bool,
    ) -> Result<Result<Texture, String>, ImportProblem> {
        let outside;
        let bytes = match (image.buffer_view, &image.uri) {
            (Some(view), _) => match self.file.view(view) {
                Ok((bytes, _)) => bytes,
                Err(what) => return Ok(Err(what)),
            },
            (None, Some(uri)) => match self.file.image(index, uri) {
                Ok(bytes) => {
                    outside = bytes;
                    &*outside
                }
                Err(limit @ ImportProblem::Limit { .. }) => return Err(limit),
                Err(problem) => return Ok(Err(problem.to_string())),
            },
            (None, None) => return Ok(Err("the image has no data".into())),
        };
        let Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) = image::guess_format(bytes) else {
            return Ok(Err("the image is neither PNG nor JPEG".into()));
        };
        let reader = || ImageReader::with_format(Cursor::new(bytes), format);
        let (width, height) = match reader().into_dimensions() {
            Ok(size) => size,
            Err(error) => return Ok(Err(shorten(&error.to_string()))),
        };
        self.texels += u64::from(width) * u64::from(height);
        let (found, limit) = (self.texels, self.limits.texture_texels);
        if found > limit {
            let what = "texels of textures";
            return Err(ImportProblem::Limit { what, found, limit, field: "texture_texels" });
        }
        let mut decoder = reader();
        let mut limits = Limits::default();
        // 16-bit RGBA at most, and what the decoder needs beside it.
        limits.max_alloc = Some(u64::from(width) * u64::from(height) * 16 + (1 << 20));
        decoder.limits(limits);
        Ok(match decoder.decode() {
            Ok(image) => {
                let image = image.into_rgba8();
                Ok(Texture {
                    width: image.width(),
                    height: image.height(),
                    texels: image.pixels().map(|p| p.0).collect(),
                    srgb,
                })
            }
            Err(error) => Err(shorten(&error.to_string())),
        })
    }
}

/// Texture coordinate set and `KHR_texture_transform` of a texture.
fn placement(info: &Info) -> (u32, Affine2) {
    let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
    let Some(transform) = transform else { return (info.tex_coord, Affine2::IDENTITY) };
    // The extension rotates counter-clockwise with v pointing down.
    let affine = Affine2::from_scale_angle_translation(
        Vec2::from(transform.scale.0),
        -transform.rotation.0,
        Vec2::from(transform.offset.0),
    );
    let affine = if affine.is_finite() { affine } else { Affine2::IDENTITY };
    (transform.tex_coord.unwrap_or(info.tex_coord), affine)
}
