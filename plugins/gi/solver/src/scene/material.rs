//! Surface descriptions: the parameters of a metallic-roughness material.

use std::sync::LazyLock;

use glam::{Affine2, Vec2, Vec3, Vec4};

use super::TextureId;

/// How alpha is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Below the cutoff the surface is not there.
    Mask(f32),
    /// Blended: such surfaces neither block nor reflect light in the solver.
    Blend,
}

/// Full metallic-roughness parameters. The solver reflects diffusely ([`Material::albedo`]); the
/// rest is kept for systems that render views.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Linear base colour and alpha, 0..1.
    pub base_color: Vec4,
    /// Multiplies `base_color`, read at the first UV set.
    pub base_color_texture: Option<TextureId>,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness, 0..1.
    pub perceptual_roughness: f32,
    /// G = roughness, B = metallic, linear.
    pub metallic_roughness_texture: Option<TextureId>,
    /// Specular reflectance of dielectrics in Bevy's sense: F0 = 0.16 reflectance².
    pub reflectance: f32,
    /// Emitted radiance, linear, already in the scene's unit.
    pub emissive: Vec3,
    /// Multiplies `emissive`.
    pub emissive_texture: Option<TextureId>,
    /// How alpha is used.
    pub alpha_mode: AlphaMode,
    /// Whether a renderer shows both sides. The solver treats every surface as two-sided: it blocks
    /// and reflects light on both.
    pub double_sided: bool,
    /// Applied to the first UV set before textures are read.
    pub uv_transform: Affine2,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 0.0,
            perceptual_roughness: 0.5,
            metallic_roughness_texture: None,
            reflectance: 0.5,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            uv_transform: Affine2::IDENTITY,
        }
    }
}

impl Material {
    /// Diffuse albedo for a base colour sample: `base (1 - metallic)` plus, so that metals do not
    /// turn rooms black, what a metal reflects, taken as diffuse: `base metallic`. For a dielectric
    /// it is the base colour. Clamped to 0..1.
    #[must_use]
    pub fn albedo(&self, base_color: Vec3) -> Vec3 {
        base_color.clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// An 8-bit RGBA image, rows from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Texture {
    /// Texels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` texels.
    pub texels: Vec<[u8; 4]>,
    /// Whether RGB is sRGB-encoded (alpha never is).
    pub srgb: bool,
}

impl Texture {
    /// Bilinear sample with repeat, decoded to linear before filtering. White for an empty image.
    #[must_use]
    pub fn sample(&self, uv: Vec2) -> Vec4 {
        if self.texels.is_empty() || !uv.is_finite() {
            return Vec4::ONE;
        }
        let (w, h) = (self.width as f32, self.height as f32);
        let x = (uv.x - uv.x.floor()) * w - 0.5;
        let y = (uv.y - uv.y.floor()) * h - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let texel = |dx: i64, dy: i64| {
            let tx = (x0 as i64 + dx).rem_euclid(i64::from(self.width)) as usize;
            let ty = (y0 as i64 + dy).rem_euclid(i64::from(self.height)) as usize;
            self.decode(self.texels[ty * self.width as usize + tx])
        };
        let top = texel(0, 0).lerp(texel(1, 0), fx);
        let bottom = texel(0, 1).lerp(texel(1, 1), fx);
        top.lerp(bottom, fy)
    }

    fn decode(&self, [r, g, b, a]: [u8; 4]) -> Vec4 {
        let channel = |v: u8| {
            if self.srgb { SRGB[usize::from(v)] } else { f32::from(v) / 255.0 }
        };
        Vec4::new(channel(r), channel(g), channel(b), f32::from(a) / 255.0)
    }
}

/// Powers are slow and every hit on a textured surface asks for a dozen.
static SRGB: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear(i as f32 / 255.0)));

/// The sRGB decoding function (IEC 61966-2-1).
fn srgb_to_linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}
