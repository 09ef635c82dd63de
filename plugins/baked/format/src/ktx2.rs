//! KTX2 textures of baked light: lightmap pages and irradiance volumes, one level, Zstandard.
//!
//! Khronos, *KTX File Format Specification*, version 2.0. Bevy reads both kinds with its features
//! `ktx2` and `zstd_rust`.
//!
//! The compressor is ruzstd's fastest, its only one: pure Rust, and half a second a page of 1024 x
//! 1024. Files of two such pages were 792 and 962 KB; libzstd at level 3 made 691 and 727 KB of them, at
//! level 19 686 and 688 KB. BC6H would need a byte a texel on the graphics card instead of four, but phones
//! and most headsets don't have it.

use std::io::Read;

use ::ktx2::{Format, Header, Index, LevelIndex, SupercompressionScheme, dfd};
use glam::{UVec3, Vec3};
use half::f16;
use ruzstd::{decoding::StreamingDecoder, encoding};
use thiserror::Error;

use crate::{rgb9e5, volume};

/// What wrote the file, as the specification asks for.
const WRITER: &str = concat!("farlight_baked_format ", env!("CARGO_PKG_VERSION"));

/// Textures with more texels are refused: a page of 8192 x 8192.
const MOST_TEXELS: u64 = 1 << 26;

/// A texture as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Texels along x, y and z; 1 in z for a page.
    pub size: UVec3,
    /// x fastest, then y from the top, then z.
    pub texels: Vec<Vec3>,
}

/// Why a texture can't be read.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("KTX2: {0}")]
pub struct Ktx2Error(String);

/// A lightmap page: a 2D texture of [`rgb9e5`] texels (`VK_FORMAT_E5B9G9R9_UFLOAT_PACK32`), `width *
/// height` values E / π in cd/m², rows from the top.
///
/// It has one level: Bevy samples no other of a lightmap. Missing texels are black, further ones are
/// ignored.
#[must_use]
pub fn lightmap_page(width: u32, height: u32, texels: &[Vec3]) -> Vec<u8> {
    let count = width as usize * height as usize;
    let mut data = Vec::with_capacity(count * 4);
    for at in 0..count {
        let texel = texels.get(at).map_or(0, |&texel| rgb9e5::encode(texel));
        data.extend_from_slice(&texel.to_le_bytes());
    }
    write(Format::E5B9G9R9_UFLOAT_PACK32, [width, height, 0], &data)
}

/// An irradiance volume: a 3D texture of half floats (`VK_FORMAT_R16G16B16A16_SFLOAT`) of size
/// [`volume::texture_size`], in the layout of [`volume::order`].
///
/// `probes` are ambient cubes: E / π in cd/m² on surfaces that face +x, -x, +y, -y, +z, -z; x
/// fastest, then y, then z. Missing ones are black.
#[must_use]
pub fn volume(resolution: UVec3, probes: &[[Vec3; 6]]) -> Vec<u8> {
    let mut data = Vec::new();
    for (probe, face) in volume::order(resolution) {
        let value = probes.get(probe).map_or(Vec3::ZERO, |faces| faces[face]);
        let [r, g, b] = value.to_array().map(half_channel);
        for half in [r, g, b, f16::ONE] {
            data.extend_from_slice(&half.to_le_bytes());
        }
    }
    write(Format::R16G16B16A16_SFLOAT, volume::texture_size(resolution).to_array(), &data)
}

/// The nearest half float; negative numbers and those that are none become 0, too large ones the
/// largest.
pub(crate) fn half_channel(v: f32) -> f16 {
    // f32::max turns NaN, which clamp keeps, into the bound.
    f16::from_f32(v.clamp(0.0, 65504.0).max(0.0))
}

impl Texture {
    /// Reads a texture that this module wrote, or another one of the same formats: its first level.
    ///
    /// # Errors
    /// If it is damaged, too large, of another format or with another compression.
    pub fn read(bytes: &[u8]) -> Result<Self, Ktx2Error> {
        let (header, level) = open(bytes)?;
        let size = size(&header)?;
        let (stride, texel): (u64, fn(&[u8]) -> Vec3) = match header.format {
            Some(Format::E5B9G9R9_UFLOAT_PACK32) => {
                (4, |t| rgb9e5::decode(u32::from_le_bytes([t[0], t[1], t[2], t[3]])))
            }
            Some(Format::R16G16B16A16_SFLOAT) => (8, |t| {
                Vec3::from_array(
                    [0, 2, 4].map(|at| f16::from_le_bytes([t[at], t[at + 1]]).to_f32()),
                )
            }),
            other => return Err(Ktx2Error(format!("format {other:?} is none of baked light"))),
        };
        let count = size.as_u64vec3().element_product();
        let data = decompress(level, header.supercompression_scheme, count * stride)?;
        Ok(Self { size, texels: data.chunks_exact(stride as usize).map(texel).collect() })
    }

    /// Reads only the size of a texture, as in [`size`](Self::size).
    ///
    /// # Errors
    /// If the file is damaged or too large.
    pub fn read_size(bytes: &[u8]) -> Result<UVec3, Ktx2Error> {
        size(&open(bytes)?.0)
    }
}

/// The header and what is stored of the first level. (The reader of the crate looks at all parts of a
/// file, and damaged data format descriptors make it panic in debug builds.)
fn open(bytes: &[u8]) -> Result<(Header, &[u8]), Ktx2Error> {
    let short = || Ktx2Error("the file ends too early".to_owned());
    let (header, rest) = bytes.split_first_chunk().ok_or_else(short)?;
    let header = Header::from_bytes(header).map_err(|error| Ktx2Error(error.to_string()))?;
    let index = LevelIndex::from_bytes(rest.first_chunk().ok_or_else(short)?);
    let start = usize::try_from(index.byte_offset).unwrap_or(usize::MAX);
    let length = usize::try_from(index.byte_length).unwrap_or(usize::MAX);
    let level = bytes.get(start..start.saturating_add(length)).ok_or_else(short)?;
    Ok((header, level))
}

fn size(header: &Header) -> Result<UVec3, Ktx2Error> {
    let size =
        UVec3::new(header.pixel_width, header.pixel_height, header.pixel_depth).max(UVec3::ONE);
    if header.layer_count > 1 || header.face_count > 1 {
        return Err(Ktx2Error("layers or faces; there is one".to_owned()));
    }
    // Three sides of 32 bits may be more than 64.
    let count = size.to_array().iter().try_fold(1_u64, |n, &side| n.checked_mul(side.into()));
    match count {
        Some(count) if count <= MOST_TEXELS => Ok(size),
        _ => Err(Ktx2Error(format!("{size} texels are more than {MOST_TEXELS}"))),
    }
}

/// Exactly `size` bytes.
fn decompress(
    data: &[u8],
    scheme: Option<SupercompressionScheme>,
    size: u64,
) -> Result<Vec<u8>, Ktx2Error> {
    let mut bytes = Vec::new();
    let read = match scheme {
        None => data.take(size).read_to_end(&mut bytes),
        Some(SupercompressionScheme::Zstandard) => {
            let decoder =
                StreamingDecoder::new(data).map_err(|error| Ktx2Error(error.to_string()))?;
            decoder.take(size).read_to_end(&mut bytes)
        }
        Some(other) => return Err(Ktx2Error(format!("compression {other:?} is not Zstandard"))),
    };
    read.map_err(|error| Ktx2Error(error.to_string()))?;
    if bytes.len() as u64 == size {
        Ok(bytes)
    } else {
        Err(Ktx2Error(format!("{} bytes of {size} are there", bytes.len())))
    }
}

/// A texture of one level. A depth of 0 is a 2D texture.
fn write(format: Format, size: [u32; 3], data: &[u8]) -> Vec<u8> {
    let (descriptor, type_size) = descriptor(format);
    let key_value = [b"KTXwriter\0", WRITER.as_bytes(), b"\0"].concat();
    let level = encoding::compress_to_vec(data, encoding::CompressionLevel::Fastest);

    // Header, index of levels, data format descriptor with its length in front, key with value and its
    // length in front, level. Nothing of it needs padding but the key: compressed levels lie anywhere.
    let dfd_offset = Header::LENGTH + LevelIndex::LENGTH;
    let dfd_length = 4 + descriptor.len();
    let kvd_offset = dfd_offset + dfd_length;
    let kvd_length = 4 + key_value.len().next_multiple_of(4);
    let header = Header {
        format: Some(format),
        type_size,
        pixel_width: size[0].max(1),
        pixel_height: size[1].max(1),
        pixel_depth: size[2],
        layer_count: 0,
        face_count: 1,
        level_count: 1,
        supercompression_scheme: Some(SupercompressionScheme::Zstandard),
        index: Index {
            dfd_byte_offset: dfd_offset as u32,
            dfd_byte_length: dfd_length as u32,
            kvd_byte_offset: kvd_offset as u32,
            kvd_byte_length: kvd_length as u32,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let index = LevelIndex {
        byte_offset: (kvd_offset + kvd_length) as u64,
        byte_length: level.len() as u64,
        uncompressed_byte_length: data.len() as u64,
    };
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend(index.as_bytes());
    bytes.extend((dfd_length as u32).to_le_bytes());
    bytes.extend(descriptor);
    bytes.extend((key_value.len() as u32).to_le_bytes());
    bytes.extend(&key_value);
    bytes.resize(kvd_offset + kvd_length, 0);
    bytes.extend(level);
    bytes
}

/// The basic data format descriptor of a format, and the size of what is swapped on machines of the
/// other endianness.
fn descriptor(format: Format) -> (Vec<u8>, u32) {
    // Both formats of this module have one; a test says so.
    dfd::Basic::from_format(format)
        .map(|(basic, type_size)| (dfd::Block::Basic(basic).to_vec(), type_size))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page() -> Vec<Vec3> {
        (0..12).map(|i| Vec3::new(i as f32 * 0.25, 1.0, 300.0 * i as f32)).collect()
    }

    fn cubes(count: u32) -> Vec<[Vec3; 6]> {
        let face = |probe: u32, face: usize| Vec3::new(probe as f32, face as f32, 0.5);
        (0..count).map(|probe| std::array::from_fn(|f| face(probe, f))).collect()
    }

    #[test]
    fn a_page_there_and_back() {
        let texture = Texture::read(&lightmap_page(4, 3, &page())).unwrap();
        assert_eq!(texture.size, UVec3::new(4, 3, 1));
        for (back, texel) in texture.texels.iter().zip(page()) {
            assert_eq!(*back, rgb9e5::decode(rgb9e5::encode(texel)));
        }
    }

    #[test]
    fn a_volume_there_and_back() {
        let resolution = UVec3::new(2, 3, 4);
        let texture = Texture::read(&volume(resolution, &cubes(24))).unwrap();
        assert_eq!(texture.size, UVec3::new(2, 6, 12));
        // Probe (1, 2, 3): the side -y (face 3) lies in the second slab of z and the second half of y.
        let at = 1 + 2 * ((3 + 2) + 6 * (4 + 3));
        assert_eq!(texture.texels[at], Vec3::new(23.0, 3.0, 0.5));
        // +z (face 4): third slab, first half.
        let at = 1 + 2 * (2 + 6 * (8 + 3));
        assert_eq!(texture.texels[at], Vec3::new(23.0, 4.0, 0.5));
    }

    #[test]
    fn missing_and_impossible_values_become_black() {
        let page = lightmap_page(2, 2, &[Vec3::ONE, Vec3::NAN]);
        let texture = Texture::read(&page).unwrap();
        assert_eq!(texture.texels, [Vec3::ONE, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO]);
        let cube =
            [Vec3::splat(1e9), Vec3::NAN, Vec3::splat(-1.0), Vec3::INFINITY, Vec3::X, Vec3::Y];
        let texture = Texture::read(&volume(UVec3::new(1, 1, 2), &[cube])).unwrap();
        let large = Vec3::splat(65504.0);
        let expected = [large, Vec3::ZERO, Vec3::ZERO, large, Vec3::X, Vec3::Y];
        for (face, expected) in expected.into_iter().enumerate() {
            let (axis, side) = (face / 2, face % 2);
            assert_eq!(texture.texels[side + 2 * (2 * axis)], expected, "{face}");
            assert_eq!(texture.texels[side + 2 * (2 * axis + 1)], Vec3::ZERO, "{face}");
        }
    }

    /// What the specification asks of a file, read back byte by byte by another crate.
    #[test]
    fn files_are_as_specified() {
        let files = [
            (lightmap_page(4, 3, &page()), Format::E5B9G9R9_UFLOAT_PACK32, 4, [4, 3, 0], 48, 6),
            (
                volume(UVec3::new(2, 3, 4), &cubes(24)),
                Format::R16G16B16A16_SFLOAT,
                2,
                [2, 6, 12],
                144 * 8,
                4,
            ),
        ];
        for (file, format, type_size, size, bytes, samples) in files {
            let reader = ::ktx2::Reader::new(&file[..]).unwrap();
            let header = reader.header();
            assert_eq!(header.format, Some(format));
            assert_eq!(header.type_size, type_size);
            assert_eq!([header.pixel_width, header.pixel_height, header.pixel_depth], size);
            assert_eq!((header.layer_count, header.face_count, header.level_count), (0, 1, 1));
            assert_eq!(header.supercompression_scheme, Some(SupercompressionScheme::Zstandard));
            assert_eq!((header.index.sgd_byte_offset, header.index.sgd_byte_length), (0, 0));
            let level = reader.levels().next().unwrap();
            assert_eq!(level.uncompressed_byte_length, bytes);
            let basic = reader.basic_dfd().unwrap();
            assert_eq!(basic.color_model, Some(::ktx2::ColorModel::RGBSDA));
            assert_eq!(basic.transfer_function, Some(::ktx2::TransferFunction::Linear));
            assert_eq!(basic.color_primaries, Some(::ktx2::ColorPrimaries::BT709));
            assert_eq!(basic.sample_information.len(), samples);
            assert_eq!(basic.bytes_planes[0], if samples == 6 { 4 } else { 8 });
            assert_eq!(reader.writer(), Some(&*format!("{WRITER}\0")));
            // The level is the last thing in the file, and everything lies on four bytes before it.
            let end = level.data.as_ptr_range().end;
            assert_eq!(end, file.as_ptr_range().end);
            assert_eq!(header.index.kvd_byte_offset % 4, 0);
            assert_eq!(header.index.kvd_byte_length % 4, 0);
        }
    }

    #[test]
    fn damaged_files_are_errors() {
        let good = lightmap_page(4, 3, &page());
        for length in 0..good.len() {
            assert!(Texture::read(&good[..length]).is_err(), "{length}");
        }
        let mut large = good.clone();
        large[20..32].fill(0xff);
        let error = Texture::read(&large).unwrap_err().to_string();
        assert!(error.starts_with("KTX2: [4294967295") && error.contains("67108864"), "{error}");
        assert_eq!(Texture::read_size(&good), Ok(UVec3::new(4, 3, 1)));
        let mut taller = good;
        taller[24] = 4;
        let error = Texture::read(&taller).unwrap_err().to_string();
        assert_eq!(error, "KTX2: 48 bytes of 64 are there");
    }
}
