//! OpenEXR pictures: scan lines or tiles, half or single floats, every compression that `exr` decodes.
//!
//! The first part with R, G and B is read (or else with Y, a grey one), at full size. Its primaries are
//! taken to be Rec. 709.

use std::{
    io::Cursor,
    panic::{AssertUnwindSafe, catch_unwind},
};

use exr::block::{self, UncompressedBlock, reader::ChunksReader};
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use glam::Vec3;

use crate::{Environment, EnvironmentError, Layout, shrink::Shrink};

pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Pieces that are decompressed at once are not larger: 256 MiB.
const LARGEST_BLOCK: usize = 1 << 28;

fn wrong(error: impl ToString) -> EnvironmentError {
    EnvironmentError::format("OpenEXR", error.to_string())
}

pub(super) fn read(bytes: &[u8], layout: Layout) -> Result<Environment, EnvironmentError> {
    // Damaged blocks of the rarer compressions make the decoder panic. What it leaves is dropped here.
    let read = AssertUnwindSafe(|| decode(bytes, layout));
    catch_unwind(read).unwrap_or_else(|_| Err(wrong("a block is damaged")))
}

fn decode(bytes: &[u8], layout: Layout) -> Result<Environment, EnvironmentError> {
    let reader = block::read(Cursor::new(bytes), false).map_err(wrong)?;
    let (part, channels) = find(reader.headers())?;
    let header = &reader.headers()[part];
    let size = [header.layer_size.width(), header.layer_size.height()];
    let [width, height] = size.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    let mut shrink = Shrink::new([width, height], layout)?;
    let [columns, lines] =
        [header.max_block_pixel_size().width(), header.max_block_pixel_size().height()];
    let block = (header.channels.bytes_per_pixel as u64)
        .saturating_mul(columns as u64)
        .saturating_mul(lines as u64);
    if block > LARGEST_BLOCK as u64 {
        let what = format!("pieces of {block} bytes are more than {LARGEST_BLOCK}");
        return Err(EnvironmentError::Size(what));
    }
    let types: Vec<SampleType> = header.channels.list.iter().map(|c| c.sample_type).collect();
    let mut missing = u64::from(width) * u64::from(height);
    let chunks = reader
        .filter_chunks(false, |_, tile, block| {
            block.layer == part && tile.level_index == exr::math::Vec2(0, 0)
        })
        .map_err(wrong)?;
    let mut row = Vec::new();
    let decoded = chunks.decompress_sequential(false, |meta, block| {
        let area = block.index.pixel_size.area() as u64;
        missing = missing.saturating_sub(area);
        take(&block, &meta.headers[part], channels, &types, &mut row, &mut shrink)
    });
    decoded.map_err(wrong)?;
    if missing > 0 {
        return Err(wrong(format!("{missing} texels are missing")));
    }
    Ok(shrink.finish())
}

/// The part to read, and which of its channels are red, green and blue.
fn find(headers: &[Header]) -> Result<(usize, [usize; 3]), EnvironmentError> {
    let mut seen = Vec::new();
    for names in [["R", "G", "B"], ["Y", "Y", "Y"]] {
        for (part, header) in headers.iter().enumerate() {
            let list = &header.channels.list;
            let place = |name: &str| list.iter().position(|channel| channel.name == *name);
            let [Some(r), Some(g), Some(b)] = names.map(place) else {
                seen.extend(list.iter().map(|channel| channel.name.to_string()));
                continue;
            };
            if header.deep {
                return unsupported("deep pictures; flatten it");
            }
            // Beside Y, RY and BY are colours at half size.
            if list.iter().any(|channel| channel.sampling != exr::math::Vec2(1, 1)) {
                return unsupported("channels of several sizes; save it as R, G and B");
            }
            if [r, g, b].iter().any(|at| list[*at].sample_type == SampleType::U32) {
                return unsupported("whole numbers; save it with half or single floats");
            }
            return Ok((part, [r, g, b]));
        }
    }
    seen.sort_unstable();
    seen.dedup();
    seen.truncate(16);
    unsupported(&format!("channels {}; needed are R, G and B (or Y)", seen.join(", ")))
}

fn unsupported<T>(what: &str) -> Result<T, EnvironmentError> {
    Err(EnvironmentError::Unsupported(format!("an OpenEXR picture with {what}")))
}

/// Hands the rows of a block on.
fn take(
    block: &UncompressedBlock,
    header: &Header,
    channels: [usize; 3],
    types: &[SampleType],
    row: &mut Vec<Vec3>,
    shrink: &mut Shrink,
) -> Result<(), exr::error::Error> {
    let invalid = || exr::error::Error::Invalid("a block is of another size".into());
    let [width, height] = [block.index.pixel_size.width(), block.index.pixel_size.height()];
    if block.data.len() as u64
        != header.channels.bytes_per_pixel as u64 * width as u64 * height as u64
    {
        return Err(invalid());
    }
    row.clear();
    row.resize(width, Vec3::ZERO);
    let mut rest = &block.data[..];
    for y in 0..height {
        for (at, kind) in types.iter().enumerate() {
            let line = width * kind.bytes_per_sample();
            let (line, after) = rest.split_at_checked(line).ok_or_else(invalid)?;
            rest = after;
            for component in (0..3).filter(|component| channels[*component] == at) {
                samples(line, *kind, row, component);
            }
        }
        let position = block.index.pixel_position;
        shrink.row(position.y() + y, position.x(), row);
    }
    Ok(())
}

/// Sets a component of the texels.
fn samples(line: &[u8], kind: SampleType, row: &mut [Vec3], component: usize) {
    match kind {
        SampleType::F16 => {
            for (texel, bytes) in row.iter_mut().zip(line.as_chunks().0) {
                texel[component] = half::f16::from_ne_bytes(*bytes).to_f32();
            }
        }
        SampleType::F32 => {
            for (texel, bytes) in row.iter_mut().zip(line.as_chunks().0) {
                texel[component] = f32::from_ne_bytes(*bytes);
            }
        }
        SampleType::U32 => {}
    }
}
