//! KTX2 textures: cubes, and equirectangular or angular pictures.
//!
//! Khronos, *KTX File Format Specification*, version 2.0. The first layer's level 0 is read.

use std::io::Read;

use glam::Vec3;
use ktx2::{Format, SupercompressionScheme};

use super::transfer::srgb_decode;
use crate::{Environment, EnvironmentError, Layout, shrink::Shrink};

pub(super) const MAGIC: [u8; 12] = ktx2::MAGIC;

fn wrong(what: impl Into<String>) -> EnvironmentError {
    EnvironmentError::format("KTX2", what)
}

pub(super) fn read(bytes: &[u8], layout: Layout) -> Result<Environment, EnvironmentError> {
    let reader = ktx2::Reader::new(bytes).map_err(|error| wrong(error.to_string()))?;
    let header = reader.header();
    if header.pixel_depth > 1 {
        return Err(EnvironmentError::Unsupported("a KTX2 texture with depth".to_owned()));
    }
    let decoder = decoder(header.format)?;
    let [width, height] = [header.pixel_width, header.pixel_height.max(1)];
    let cube = header.face_count == 6;
    let (size, layout) = match (cube, layout) {
        (true, Layout::Auto | Layout::Cube) if width == height => {
            ([width, height.saturating_mul(6)], Layout::Cube)
        }
        (true, Layout::Auto | Layout::Cube) => {
            return Err(wrong(format!("faces of {width} x {height} texels are no squares")));
        }
        (true, layout) => {
            return Err(EnvironmentError::Size(format!("a KTX2 cube is not of layout {layout}")));
        }
        (false, layout) => ([width, height], layout),
    };
    let mut shrink = Shrink::new(size, layout)?;
    let level = reader.levels().next().ok_or_else(|| wrong("there is no level"))?;
    let mut data: Box<dyn Read> = match header.supercompression_scheme {
        None => Box::new(level.data),
        Some(SupercompressionScheme::Zstandard) => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(level.data);
            Box::new(decoder.map_err(|error| wrong(error.to_string()))?)
        }
        Some(other) => {
            return Err(EnvironmentError::Unsupported(format!(
                "a KTX2 texture with {other:?} compression; use Zstandard or none"
            )));
        }
    };
    let mut row = vec![0; size[0] as usize * decoder.bytes];
    for y in 0..size[1] as usize {
        data.read_exact(&mut row)
            .map_err(|error| wrong(format!("row {y} of {}: {error}", size[1])))?;
        let texels: Vec<Vec3> = row.chunks_exact(decoder.bytes).map(decoder.texel).collect();
        shrink.row(y, 0, &texels);
    }
    Ok(shrink.finish())
}

/// How texels are stored.
struct Decoder {
    /// Of a texel.
    bytes: usize,
    texel: fn(&[u8]) -> Vec3,
}

fn decoder(format: Option<Format>) -> Result<Decoder, EnvironmentError> {
    let (bytes, texel): (usize, fn(&[u8]) -> Vec3) = match format {
        Some(Format::R8G8B8A8_UNORM) => (4, |t| unorm(t)),
        Some(Format::R8G8B8A8_SRGB) => (4, |t| unorm(t).map(srgb_decode)),
        Some(Format::R16G16B16A16_SFLOAT) => (8, |t| {
            Vec3::from_array(
                [0, 2, 4].map(|at| half::f16::from_le_bytes([t[at], t[at + 1]]).to_f32()),
            )
        }),
        Some(Format::R32G32B32A32_SFLOAT) => {
            (16, |t| Vec3::from_array([0, 4, 8].map(|at| f32::from_bits(word(&t[at..])))))
        }
        Some(Format::E5B9G9R9_UFLOAT_PACK32) => (4, |t| shared_exponent(word(t))),
        Some(Format::B10G11R11_UFLOAT_PACK32) => (4, |t| small_floats(word(t))),
        other => {
            let name = other.map_or("Basis Universal".to_owned(), |format| format!("{format:?}"));
            return Err(EnvironmentError::Unsupported(format!(
                "a KTX2 texture of {name}; convert it to R16G16B16A16_SFLOAT, R32G32B32A32_SFLOAT, \
                 E5B9G9R9_UFLOAT_PACK32, B10G11R11_UFLOAT_PACK32, R8G8B8A8_SRGB or R8G8B8A8_UNORM"
            )));
        }
    };
    Ok(Decoder { bytes, texel })
}

fn word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

fn unorm(bytes: &[u8]) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|at| f32::from(bytes[at]) / 255.0))
}

/// Nine bits a channel and five that they share (Khronos Data Format Specification, section 13.4).
fn shared_exponent(word: u32) -> Vec3 {
    let scale = ((word >> 27) as f32 - 24.0).exp2();
    Vec3::from_array([0, 9, 18].map(|shift| ((word >> shift) & 0x1ff) as f32 * scale))
}

/// Unsigned floats of 11, 11 and 10 bits (Khronos Data Format Specification, sections 13.2 and 13.3): the
/// upper bits of half floats, without the sign.
fn small_floats(word: u32) -> Vec3 {
    let half = |bits: u32| half::f16::from_bits(bits as u16).to_f32();
    let [r, g, b] = [word & 0x7ff, (word >> 11) & 0x7ff, word >> 22];
    Vec3::new(half(r << 4), half(g << 4), half(b << 5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_floats() {
        // 1 is 2^8 units of 2^-24 at exponent 16.
        assert_eq!(
            shared_exponent(16 << 27 | 0x100 | 0x80 << 9 | 0x1 << 18),
            Vec3::new(1.0, 0.5, 1.0 / 256.0)
        );
        // Exponent 15 is 2^0; six bits of mantissa (five for blue).
        assert_eq!(small_floats(15 << 6 | 16 << 17 | 14 << 27), Vec3::new(1.0, 2.0, 0.5));
        assert_eq!(small_floats(0x7c0), Vec3::new(f32::INFINITY, 0.0, 0.0));
        assert!(small_floats(0x7c1).x.is_nan());
    }
}
