//! Lightmap pages as OpenEXR pictures, for people and other programs.
//!
//! Half floats R, G and B, scan lines, compressed by ZIP without loss. The values are those of the
//! lightmap: E / π in cd/m², linear Rec. 709.

use std::{io::Cursor, panic::catch_unwind};

use ::exr::prelude::{
    Compression, Encoding, Image, ImageAttributes, Layer, LayerAttributes, LineOrder, ReadChannels,
    ReadLayers, SpecificChannels, Text, Vec2, WritableImage, f16, read,
};
use glam::Vec3;
use thiserror::Error;

use crate::ktx2::half_channel;

/// Larger pictures are refused: 8192 x 8192.
const MOST_TEXELS: usize = 1 << 26;

/// Why a picture can't be written or read.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("OpenEXR: {0}")]
pub struct ExrError(String);

impl From<::exr::error::Error> for ExrError {
    fn from(error: ::exr::error::Error) -> Self {
        Self(error.to_string())
    }
}

/// A picture as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Texels along x.
    pub width: u32,
    /// Texels along y.
    pub height: u32,
    /// Rows from the top.
    pub texels: Vec<Vec3>,
}

/// The file of a page: `width * height` values E / π in cd/m², rows from the top. Missing texels are
/// black, and so are values that are negative or not a number; too large ones become 65504.
///
/// # Errors
/// If a side is 0.
pub fn write(width: u32, height: u32, texels: &[Vec3]) -> Result<Vec<u8>, ExrError> {
    if width == 0 || height == 0 {
        return Err(ExrError(format!("{width} x {height} texels are none")));
    }
    let size = Vec2(width as usize, height as usize);
    let texel = |at: Vec2<usize>| {
        let texel = texels.get(at.x() + at.y() * size.x()).copied().unwrap_or_default();
        let [r, g, b] =
            texel.to_array().map(half_channel).map(|half| f16::from_bits(half.to_bits()));
        (r, g, b)
    };
    let encoding = Encoding {
        compression: Compression::ZIP16,
        line_order: LineOrder::Increasing,
        ..Encoding::FAST_LOSSLESS
    };
    let attributes = LayerAttributes {
        software_name: Text::new_or_none(env!("CARGO_PKG_NAME")),
        ..Default::default()
    };
    let layer = Layer::new(size, attributes, encoding, SpecificChannels::rgb(texel));
    let mut image = Image::from_layer(layer);
    image.attributes = ImageAttributes::with_size(size);
    let mut bytes = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

impl Picture {
    /// Reads the first layer with channels R, G and B, of half or single floats.
    ///
    /// # Errors
    /// If it is damaged or has no such layer.
    pub fn read(bytes: &[u8]) -> Result<Self, ExrError> {
        // Damaged blocks of the rarer compressions make the decoder panic. What it leaves is dropped
        // here.
        catch_unwind(|| Self::decode(bytes))
            .unwrap_or_else(|_| Err(ExrError("a block is damaged".to_owned())))
    }

    fn decode(bytes: &[u8]) -> Result<Self, ExrError> {
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(
                |size, _| {
                    let texels = if size.area() <= MOST_TEXELS { size.area() } else { 0 };
                    (size.width(), vec![Vec3::ZERO; texels])
                },
                |(width, texels): &mut (usize, Vec<Vec3>), at, (r, g, b): (f32, f32, f32)| {
                    if let Some(texel) = texels.get_mut(at.x() + at.y() * *width) {
                        *texel = Vec3::new(r, g, b);
                    }
                },
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))?;
        let [width, height] =
            [image.layer_data.size.width(), image.layer_data.size.height()].map(|side| side as u32);
        let (_, texels) = image.layer_data.channel_data.pixels;
        if texels.len() != image.layer_data.size.area() {
            return Err(ExrError(format!("{width} x {height} texels are more than {MOST_TEXELS}")));
        }
        Ok(Self { width, height, texels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_there_and_back() {
        let texels: Vec<Vec3> = (0..40 * 21)
            .map(|i| Vec3::new(i as f32, 0.001 * i as f32, (i * i) as f32 * 0.1))
            .collect();
        let bytes = write(40, 21, &texels).unwrap();
        let picture = Picture::read(&bytes).unwrap();
        assert_eq!((picture.width, picture.height), (40, 21));
        for (back, texel) in picture.texels.iter().zip(texels) {
            let expected = texel.to_array().map(|v| half_channel(v).to_f32());
            assert_eq!(back.to_array(), expected);
        }
    }

    #[test]
    fn impossible_values_become_black() {
        let bytes = write(2, 2, &[Vec3::NAN, Vec3::splat(-1.0), Vec3::INFINITY]).unwrap();
        let texels = Picture::read(&bytes).unwrap().texels;
        assert_eq!(texels, [Vec3::ZERO, Vec3::ZERO, Vec3::splat(65504.0), Vec3::ZERO]);
    }

    #[test]
    fn damaged_files_are_errors() {
        let bytes = write(4, 3, &[Vec3::ONE; 12]).unwrap();
        for length in 0..bytes.len() {
            assert!(Picture::read(&bytes[..length]).is_err(), "{length} of {}", bytes.len());
        }
        assert!(write(0, 3, &[]).is_err());
    }
}
