//! Pictures that the gallery makes itself, with all their coarser copies.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

/// Metres along an edge of the picture of planks; it repeats.
pub const PLANKS: f32 = 1.6;
const PLANKS_EDGE: u32 = 512;
/// Planks side by side in the picture.
const ROWS: u32 = 10;

/// An oak floor: long boards along z with some difference in tone, fine grain, thin dark joints.
pub fn planks() -> Image {
    let mut pixels = Vec::with_capacity((PLANKS_EDGE * PLANKS_EDGE) as usize);
    for y in 0..PLANKS_EDGE {
        for x in 0..PLANKS_EDGE {
            let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / PLANKS_EDGE as f32;
            pixels.push(plank(place));
        }
    }
    image(PLANKS_EDGE, PLANKS_EDGE, pixels, true)
}

/// Linear colour of a place of the repeating square.
fn plank(place: Vec2) -> Vec3 {
    let across = place.x * ROWS as f32;
    let row = across.floor();
    // Boards begin at different places, and are as long as the picture.
    let along = (place.y + noise(row as u32 * 71 + 5)).fract();
    let tone = noise(row as u32 * 131 + 17);
    let grain = 0.5
        * (wave(across * 9.0 + 0.6 * wave(along * 2.0, row as u32), 3 + row as u32)
            + wave(across * 23.0, 40 + row as u32));
    let oak = Vec3::new(0.395, 0.255, 0.148);
    let colour = oak * (0.86 + 0.26 * tone) * (1.0 + 0.07 * grain);
    // A joint of 1.5 mm between boards, and one where a board ends.
    let from_joint = (across.fract() - 0.5).abs().mul_add(-2.0, 1.0) * 0.5 * PLANKS / ROWS as f32;
    let from_end = along.min(1.0 - along) * PLANKS;
    let gap = 0.0022;
    let open = (from_joint.min(from_end) / gap).clamp(0.0, 1.0);
    colour * (0.45 + 0.55 * open)
}

/// A smooth wave of period 1 along `at` with a phase of its own, from -1 to 1.
fn wave(at: f32, seed: u32) -> f32 {
    ((at + noise(seed)) * std::f32::consts::TAU).sin()
}

/// A number from 0 to 1.
fn noise(seed: u32) -> f32 {
    let mut x = seed.wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
    x = (x ^ (x >> 15)).wrapping_mul(0x2C1B_3C6D);
    x = (x ^ (x >> 12)).wrapping_mul(0x297A_2D39);
    (x ^ (x >> 15)) as f32 / u32::MAX as f32
}

/// An sRGB image of linear pixels, rows from the top, with all of its coarser copies down to a pixel.
pub fn image(width: u32, height: u32, pixels: Vec<Vec3>, repeats: bool) -> Image {
    let mut data = Vec::new();
    let (mut size, mut level, mut levels) = (UVec2::new(width, height), pixels, 0);
    loop {
        for pixel in &level {
            let colour = Color::linear_rgb(pixel.x, pixel.y, pixel.z).to_srgba();
            data.extend(colour.to_u8_array());
        }
        levels += 1;
        if size == UVec2::ONE {
            break;
        }
        let next = (size / 2).max(UVec2::ONE);
        level = coarser(&level, size, next);
        size = next;
    }
    let mut image = Image::new_uninit(
        Extent3d { width, height, depth_or_array_layers: 1 },
        TextureDimension::D2,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    image.texture_descriptor.mip_level_count = levels;
    image.data = Some(data);
    let edge = if repeats { ImageAddressMode::Repeat } else { ImageAddressMode::ClampToEdge };
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: edge,
        address_mode_v: edge,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        mipmap_filter: ImageFilterMode::Linear,
        anisotropy_clamp: 8,
        ..default()
    });
    image
}

/// A picture of half the size: means of what falls into a pixel.
fn coarser(fine: &[Vec3], size: UVec2, next: UVec2) -> Vec<Vec3> {
    let pixel = |x: u32, y: u32| fine[(y.min(size.y - 1) * size.x + x.min(size.x - 1)) as usize];
    let mut coarse = Vec::with_capacity(next.element_product() as usize);
    for y in 0..next.y {
        for x in 0..next.x {
            let [a, b] = [2 * x, 2 * x + 1];
            let sum = pixel(a, 2 * y) + pixel(b, 2 * y) + pixel(a, 2 * y + 1) + pixel(b, 2 * y + 1);
            coarse.push(sum / 4.0);
        }
    }
    coarse
}
