//! What `shaders/baked/blend.wgsl` does, on the CPU: its specification, and its stand-in where there are
//! no compute shaders.

use bevy::{math::Vec3, prelude::Image, render::render_resource::TextureFormat};
use half::f16;

/// The largest half float.
const MOST: f32 = 65504.0;

/// The sum of texels, each by its weight, as half floats with an alpha of 1.
#[must_use]
pub fn blend_texel(texels: impl IntoIterator<Item = (Vec3, f32)>) -> [f16; 4] {
    let sum = texels.into_iter().fold(Vec3::ZERO, |sum, (texel, weight)| sum + weight * texel);
    let sum = sum.clamp(Vec3::ZERO, Vec3::splat(MOST));
    [sum.x, sum.y, sum.z, 1.0].map(f16::from_f32)
}

/// A texel of three 9-bit mantissas that share a 5-bit exponent (OpenGL's `EXT_texture_shared_exponent`,
/// Vulkan's `E5B9G9R9_UFLOAT_PACK32`).
#[must_use]
pub fn decode_rgb9e5(texel: u32) -> Vec3 {
    let scale = f32::exp2((texel >> 27) as f32 - 15.0 - 9.0);
    let mantissa = |shift: u32| (texel >> shift & 0x1ff) as f32;
    Vec3::new(mantissa(0), mantissa(9), mantissa(18)) * scale
}

/// The first mip level of all images, blended: bytes of half floats.
///
/// # Errors
/// An image whose texels are not here, or whose format is none of `Rgb9e5Ufloat` and `Rgba16Float`.
pub(crate) fn blend_images(images: &[(&Image, f32)]) -> Result<Vec<u8>, String> {
    let Some((first, _)) = images.first() else { return Ok(Vec::new()) };
    let size = first.texture_descriptor.size;
    let texels = size.width as usize * size.height as usize * size.depth_or_array_layers as usize;
    let mut sources = Vec::new();
    for (image, weight) in images {
        let format = image.texture_descriptor.format;
        let data = image.data.as_deref().ok_or("its texels are on the GPU only")?;
        let stride = match format {
            TextureFormat::Rgb9e5Ufloat => 4,
            TextureFormat::Rgba16Float => 8,
            _ => return Err(format!("texels of {format:?} can't be blended on the CPU")),
        };
        if data.len() < texels * stride {
            return Err(format!("{} bytes are not {texels} texels", data.len()));
        }
        sources.push((data, stride, *weight));
    }
    let texel = |(data, stride, weight): &(&[u8], usize, f32), index: usize| {
        let bytes = &data[index * stride..][..*stride];
        let half = |at: usize| f16::from_le_bytes([bytes[at], bytes[at + 1]]).to_f32();
        let value = if *stride == 4 {
            decode_rgb9e5(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
        } else {
            Vec3::new(half(0), half(2), half(4))
        };
        (value, *weight)
    };
    let mut mixed = Vec::with_capacity(texels * 8);
    for index in 0..texels {
        let blended = blend_texel(sources.iter().map(|source| texel(source, index)));
        blended.iter().for_each(|value| mixed.extend_from_slice(&value.to_le_bytes()));
    }
    Ok(mixed)
}

#[cfg(test)]
mod tests {
    use bevy::{
        asset::RenderAssetUsages,
        render::render_resource::{Extent3d, TextureDimension},
    };

    use super::*;

    #[test]
    fn shared_exponents() {
        // 1.0 is 256 / 512 * 2^1: exponent 16, mantissa 256.
        assert_eq!(decode_rgb9e5(16 << 27 | 256), Vec3::X);
        assert_eq!(
            decode_rgb9e5(16 << 27 | 128 << 9 | 511 << 18),
            Vec3::new(0.0, 0.5, 511.0 / 256.0)
        );
        assert_eq!(decode_rgb9e5(u32::MAX), Vec3::splat(511.0 * 128.0));
        assert_eq!(decode_rgb9e5(0), Vec3::ZERO);
    }

    #[test]
    fn images_of_two_formats_add_up() {
        let size = Extent3d { width: 2, height: 1, depth_or_array_layers: 1 };
        let image = |format, data: Vec<u8>| {
            Image::new(size, TextureDimension::D2, data, format, RenderAssetUsages::default())
        };
        let shared = [16_u32 << 27 | 256, 16 << 27 | 256 << 18].map(u32::to_le_bytes);
        let shared = image(TextureFormat::Rgb9e5Ufloat, shared.as_flattened().to_vec());
        let halves = [f16::from_f32(3.0); 8].map(f16::to_le_bytes);
        let halves = image(TextureFormat::Rgba16Float, halves.as_flattened().to_vec());
        let mixed = blend_images(&[(&shared, 0.5), (&halves, 2.0)]).unwrap();
        let mixed: Vec<f32> =
            mixed.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect();
        assert_eq!(mixed, [6.5, 6.0, 6.0, 1.0, 6.0, 6.0, 6.5, 1.0]);
        let mut gone = shared.clone();
        gone.data = None;
        assert!(blend_images(&[(&gone, 1.0)]).is_err());
    }

    #[test]
    fn what_half_floats_cannot_hold_is_cut() {
        let mixed = blend_texel([(Vec3::new(1e9, -1.0, 1.0), 1.0)]);
        assert_eq!(mixed.map(f16::to_f32), [MOST, 0.0, 1.0, 1.0]);
    }
}
