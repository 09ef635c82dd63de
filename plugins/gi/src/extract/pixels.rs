//! Pixels of Bevy's images for the solver: small, 8 bits, or linear floats for skies.

use bevy::{
    image::Image,
    math::{Vec3, Vec4},
    prelude::*,
    render::render_resource::TextureDimension,
};
use farlight_gi_solver::scene::{SkyImage, Texture};

/// Longest edge of a texture for the solver. Indirect light doesn't see finer detail, and masks
/// still have their shape.
const MAX_TEXTURE: u32 = 512;

/// Longest edge of a sky for the solver.
const MAX_SKY: u32 = 1024;

/// Whether the solver can read the image, and why not.
pub(super) fn problem(image: &Image) -> Option<String> {
    if image.texture_descriptor.dimension != TextureDimension::D2 {
        return Some("it isn't two-dimensional".into());
    }
    if image.data.is_none() {
        return Some("its pixels aren't on the CPU".into());
    }
    if image.get_color_at(0, 0).is_err() {
        return Some(format!("{:?} can't be read on the CPU", image.texture_descriptor.format));
    }
    None
}

/// The image shrunk by averaging linear values, in 8 bits sRGB.
pub(super) fn texture(image: &Image) -> Texture {
    let (width, height, texels) = shrink(image, MAX_TEXTURE);
    let encode = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let texels = texels
        .into_iter()
        .map(|texel| {
            let encoded = Srgba::from(LinearRgba::from_vec4(texel));
            [encode(encoded.red), encode(encoded.green), encode(encoded.blue), encode(texel.w)]
        })
        .collect();
    Texture { width, height, texels, srgb: true }
}

/// The image as linear radiance, shrunk.
pub(super) fn sky(image: &Image) -> SkyImage {
    let (width, height, texels) = shrink(image, MAX_SKY);
    let finite = |v: f32| if v.is_finite() { v.max(0.0) } else { 0.0 };
    let texels =
        texels.into_iter().map(|t| Vec3::new(finite(t.x), finite(t.y), finite(t.z))).collect();
    SkyImage { width, height, texels }
}

/// Averages boxes so that no edge is longer than `longest`; linear RGBA.
fn shrink(image: &Image, longest: u32) -> (u32, u32, Vec<Vec4>) {
    let (w, h) = (image.width().max(1), image.height().max(1));
    let factor = w.max(h).div_ceil(longest).max(1);
    let (width, height) = (w.div_ceil(factor), h.div_ceil(factor));
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut count) = (Vec4::ZERO, 0.0);
            for sy in y * factor..((y + 1) * factor).min(h) {
                for sx in x * factor..((x + 1) * factor).min(w) {
                    if let Ok(color) = image.get_color_at(sx, sy) {
                        sum += color.to_linear().to_vec4();
                        count += 1.0;
                    }
                }
            }
            texels.push(if count > 0.0 { sum / count } else { Vec4::ONE });
        }
    }
    (width, height, texels)
}

#[cfg(test)]
mod tests {
    use bevy::{
        asset::RenderAssetUsages,
        render::render_resource::{Extent3d, TextureFormat},
    };

    use super::*;

    #[test]
    fn large_images_are_averaged_in_linear_light() {
        // Black and white columns: the mean is linear 0.5, which is 188 in sRGB.
        let (width, height) = (1024, 4);
        let data = (0..width * height)
            .flat_map(|i| if i % 2 == 0 { [0, 0, 0, 255] } else { [255, 255, 255, 255] })
            .collect();
        let image = Image::new(
            Extent3d { width, height, depth_or_array_layers: 1 },
            TextureDimension::D2,
            data,
            TextureFormat::Rgba8UnormSrgb,
            RenderAssetUsages::default(),
        );
        assert_eq!(problem(&image), None);
        let texture = texture(&image);
        assert_eq!((texture.width, texture.height), (512, 2));
        assert!(texture.texels.iter().all(|t| t[0].abs_diff(188) <= 1 && t[3] == 255));
    }
}
