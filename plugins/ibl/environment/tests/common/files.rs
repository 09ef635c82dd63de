//! Files of every format, in memory.

use std::io::Cursor;

use exr::prelude::*;
use glam::Vec3;
use ktx2::{Format, Header, LevelIndex, SupercompressionScheme};

/// A Radiance picture; `packed` with run lengths by channel.
pub(crate) fn radiance(size: [usize; 2], texels: &[Vec3], packed: bool) -> Vec<u8> {
    let [width, height] = size;
    if packed {
        let mut bytes = Vec::new();
        let pixels: Vec<_> = texels.iter().map(|texel| image::Rgb(texel.to_array())).collect();
        let encoder = image::codecs::hdr::HdrEncoder::new(&mut bytes);
        encoder.encode(&pixels, width, height).unwrap();
        return bytes;
    }
    let mut bytes = format!("#?RADIANCE\n# plain\n\n-Y {height} +X {width}\n").into_bytes();
    for texel in texels {
        bytes.extend(rgbe(*texel));
    }
    bytes
}

/// Mantissas and exponent, rounded down.
pub(crate) fn rgbe(texel: Vec3) -> [u8; 4] {
    let greatest = texel.max_element();
    if greatest <= 0.0 {
        return [0; 4];
    }
    let exponent = greatest.log2().floor() as i32 + 1;
    let [r, g, b] = (texel * (8.0 - exponent as f32).exp2()).to_array().map(|v| v as u8);
    [r, g, b, (exponent + 128) as u8]
}

/// An OpenEXR picture of half or single floats.
pub(crate) fn openexr(
    size: [usize; 2],
    texels: &[Vec3],
    half: bool,
    encoding: Encoding,
) -> Vec<u8> {
    let [width, height] = size;
    let mut bytes = Cursor::new(Vec::new());
    let texel = |at: Vec2<usize>| texels[at.y() * width + at.x()];
    let attributes = LayerAttributes::named("main");
    if half {
        let channels = SpecificChannels::rgb(|at| {
            let [r, g, b] = texel(at).to_array().map(f16::from_f32);
            (r, g, b)
        });
        let layer = Layer::new((width, height), attributes, encoding, channels);
        Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    } else {
        let channels = SpecificChannels::rgba(|at| {
            let [r, g, b] = texel(at).to_array();
            (r, g, b, 1.0_f32)
        });
        let layer = Layer::new((width, height), attributes, encoding, channels);
        Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    }
    bytes.into_inner()
}

/// A KTX2 texture with one level.
pub(crate) fn ktx(
    size: [u32; 2],
    faces: u32,
    format: Option<Format>,
    data: &[u8],
    zstd: bool,
) -> Vec<u8> {
    let level = if zstd {
        let fastest = ruzstd::encoding::CompressionLevel::Fastest;
        ruzstd::encoding::compress_to_vec(data, fastest)
    } else {
        data.to_vec()
    };
    // Header, index of levels, the length of a data format descriptor without blocks, padding.
    let start = Header::LENGTH + LevelIndex::LENGTH + 8;
    let header = Header {
        format,
        type_size: 1,
        pixel_width: size[0],
        pixel_height: size[1],
        pixel_depth: 0,
        layer_count: 0,
        face_count: faces,
        level_count: 1,
        supercompression_scheme: zstd.then_some(SupercompressionScheme::Zstandard),
        index: ktx2::Index {
            dfd_byte_offset: (Header::LENGTH + LevelIndex::LENGTH) as u32,
            dfd_byte_length: 4,
            kvd_byte_offset: 0,
            kvd_byte_length: 0,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let index = LevelIndex {
        byte_offset: start as u64,
        byte_length: level.len() as u64,
        uncompressed_byte_length: data.len() as u64,
    };
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend(index.as_bytes());
    bytes.extend(4_u32.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(level);
    bytes
}

/// A PNG or JPEG picture.
pub(crate) fn screen(size: [u32; 2], pixels: &[[u8; 3]], format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let raw = pixels.iter().flatten().copied().collect();
    let picture = image::RgbImage::from_raw(size[0], size[1], raw).unwrap();
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}
