//! PNG and JPEG pictures: made for screens, so white is the brightest light that they hold.

use std::io::Cursor;

use glam::Vec3;
use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use super::transfer::srgb_decode;
use crate::{Environment, EnvironmentError, Layout, shrink::Shrink};

/// A decoder may take this much in any case, for its tables.
const FIXED: u64 = 1 << 24;
/// Bytes of a picture for a byte of its file: Deflate reaches 1032, JPEG less.
const DENSEST: u64 = 1100;
/// A decoder may never take more: 2 GiB.
const MOST: u64 = 1 << 31;

pub(super) fn read(
    bytes: &[u8],
    format: ImageFormat,
    layout: Layout,
) -> Result<Environment, EnvironmentError> {
    let name = if format == ImageFormat::Png { "PNG" } else { "JPEG" };
    let wrong = |error: image::ImageError| EnvironmentError::format(name, error.to_string());
    let open = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = open().into_dimensions().map_err(wrong)?;
    let mut shrink = Shrink::new([width, height], layout)?;
    let mut reader = open();
    let mut limits = Limits::default();
    // A header that lies about its size must not cost more than an honest file of that length.
    limits.max_alloc = Some((DENSEST * bytes.len() as u64 + FIXED).min(MOST));
    reader.limits(limits);
    let mut row = Vec::with_capacity(width as usize);
    match reader.decode().map_err(wrong)? {
        wide @ (DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_)) => {
            for (y, pixels) in wide.into_rgb16().rows().enumerate() {
                row.clear();
                row.extend(pixels.map(|p| linear(p.0.map(|value| f32::from(value) / 65535.0))));
                shrink.row(y, 0, &row);
            }
        }
        narrow => {
            let table: [f32; 256] = std::array::from_fn(|value| srgb_decode(value as f32 / 255.0));
            for (y, pixels) in narrow.into_rgb8().rows().enumerate() {
                row.clear();
                row.extend(pixels.map(|p| Vec3::from_array(p.0.map(|v| table[usize::from(v)]))));
                shrink.row(y, 0, &row);
            }
        }
    }
    Ok(shrink.finish())
}

fn linear(rgb: [f32; 3]) -> Vec3 {
    Vec3::from_array(rgb.map(srgb_decode))
}
