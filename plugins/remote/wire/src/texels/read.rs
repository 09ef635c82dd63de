//! Reading light.

use std::{sync::Arc, time::Duration};

use farlight_gi_solver::{
    atlas::{PageId, TexelRect},
    scene::InstanceId,
    session::{GridId, Placement, Quality, SnapshotId},
};
use glam::UVec3;

use super::{REASON, REFUSED, is_rect, least_code, probes_of};
use crate::{
    HalfGrid, HalfTile, LightingMessage, Limits, Piece, ServerTimes, WireError,
    codec::{RangeDecoder, Reader},
};

/// What errors call it.
const WHAT: &str = "a lighting message";

impl LightingMessage {
    /// Back from [`encode`](Self::encode). All sizes are checked before memory is taken.
    ///
    /// # Errors
    /// It is not an encoding, or over a limit: `limits.texels` texels or `limits.probes` probes in one
    /// message (or in a grid), `limits.objects` placements, 4096 refused receivers of at most 256
    /// bytes of text. Or not valid: rectangles lie on a page below 64, have at least one texel and
    /// end at 4096; runs of probes lie in their grid.
    pub fn decode(bytes: &[u8], limits: &Limits) -> Result<Self, WireError> {
        let message = Self::decode_beside(bytes, limits, |_, _| None)?;
        if !message.is_whole() {
            return Err(WireError::invalid(WHAT, "it builds on a message that is not there"));
        }
        Ok(message)
    }

    /// [`decode`](Self::decode) of what [`encode_beside`](Self::encode_beside) made. `base` answers
    /// what a message brought of a piece. Pieces whose base is not there are without their content.
    ///
    /// # Errors
    /// As `decode`, or a base is of a message that can't have come before.
    pub fn decode_beside<'a>(
        bytes: &[u8],
        limits: &Limits,
        base: impl Fn(Piece, u64) -> Option<&'a [[u16; 3]]>,
    ) -> Result<Self, WireError> {
        let mut reader = Reader::new(WHAT, bytes);
        let mut message = Self {
            sequence: reader.varint()?,
            snapshot: SnapshotId(reader.varint()?),
            times: read_times(&mut reader)?,
            quality: read_quality(&mut reader)?,
            placements: read_placements(&mut reader, limits)?,
            refused: read_refused(&mut reader)?,
            ..Self::default()
        };
        let tiles = read_tiles(&mut reader, limits)?;
        let grids = read_grids(&mut reader, limits)?;
        let code = reader.bytes(usize::MAX)?;
        reader.end()?;
        let texels = tiles.iter().map(|(_, rect, _)| rect.area()).sum();
        let probes = grids.iter().map(|(_, count, _)| count).sum();
        if code.len() < least_code(texels, probes) {
            return Err(reader.invalid("it says that it holds more light than its bytes can"));
        }
        let mut bases: Vec<Option<&[[u16; 3]]>> = Vec::with_capacity(tiles.len() + grids.len());
        let mut missing = Vec::new();
        let tile_bases =
            tiles.iter().map(|(page, rect, far)| (Piece::Tile(*page, *rect), rect.area(), *far));
        let grid_bases = grids.iter().map(|(grid, count, far)| (grid.piece(), count * 9, *far));
        for (i, (piece, size, distance)) in tile_bases.chain(grid_bases).enumerate() {
            let number = message.sequence.checked_sub(distance);
            let number = number.ok_or_else(|| reader.invalid("it builds on no message"))?;
            let found = (distance > 0).then(|| base(piece, number));
            let found = found.map(|found| found.filter(|values| values.len() == size));
            if found == Some(None) {
                missing.push(i);
            }
            bases.push(found.map(Option::unwrap_or_default));
        }
        message.tiles = tiles
            .iter()
            .map(|&(page, rect, _)| HalfTile { page, rect, texels: vec![[0; 3]; rect.area()] })
            .collect();
        message.grids = grids
            .into_iter()
            .map(|(grid, count, _)| HalfGrid { probes: vec![[[0; 3]; 9]; count], ..grid })
            .collect();
        if texels + probes > 0 {
            message.code(&mut RangeDecoder::new(WHAT, code)?, &bases);
        }
        for i in missing {
            match i.checked_sub(message.tiles.len()) {
                None => message.tiles[i].texels.clear(),
                Some(i) => message.grids[i].probes.clear(),
            }
        }
        Ok(message)
    }

    /// Whether everything has its content; see [`decode_beside`](Self::decode_beside).
    pub(crate) fn is_whole(&self) -> bool {
        self.tiles.iter().all(|tile| !tile.texels.is_empty())
            && self.grids.iter().all(|grid| !grid.probes.is_empty())
    }
}

fn read_times(reader: &mut Reader<'_>) -> Result<ServerTimes, WireError> {
    let mut time = || reader.u32().map(|micros| Duration::from_micros(micros.into()));
    Ok(ServerTimes { held: time()?, solve: time()?, encode: time()? })
}

fn read_quality(reader: &mut Reader<'_>) -> Result<Quality, WireError> {
    let [relative_error] = reader.floats()?;
    Ok(Quality { relative_error, rays_per_texel: read_u32(reader)?, converged: reader.flag()? })
}

fn read_placements(reader: &mut Reader<'_>, limits: &Limits) -> Result<Vec<Placement>, WireError> {
    let count = reader.count(6, limits.objects)?;
    let placement = |_| {
        let instance = InstanceId(reader.varint()?);
        let (page, rect) = read_rect(reader)?;
        Ok(Placement { instance, page, rect })
    };
    (0..count).map(placement).collect()
}

fn read_refused(reader: &mut Reader<'_>) -> Result<Vec<(InstanceId, Arc<str>)>, WireError> {
    let count = reader.count(2, REFUSED)?;
    let refused = |_| Ok((InstanceId(reader.varint()?), reader.text(REASON)?.into()));
    (0..count).map(refused).collect()
}

fn read_tiles(
    reader: &mut Reader<'_>,
    limits: &Limits,
) -> Result<Vec<(PageId, TexelRect, u64)>, WireError> {
    let count = reader.count(6, limits.texels)?;
    let mut texels = 0_usize;
    let tile = |_| {
        let (page, rect) = read_rect(reader)?;
        texels = texels.saturating_add(rect.area());
        WireError::check("texels of a lighting message", texels, limits.texels)?;
        Ok((page, rect, reader.varint()?))
    };
    (0..count).map(tile).collect()
}

/// Grids without probes, and how many there are.
fn read_grids(
    reader: &mut Reader<'_>,
    limits: &Limits,
) -> Result<Vec<(HalfGrid, usize, u64)>, WireError> {
    let count = reader.count(7, limits.objects)?;
    let mut probes = 0_usize;
    let grid = |_| {
        let grid = HalfGrid {
            grid: GridId(reader.varint()?),
            resolution: UVec3::new(read_u32(reader)?, read_u32(reader)?, read_u32(reader)?),
            first: read_u32(reader)?,
            probes: Vec::new(),
        };
        let count = read_u32(reader)?;
        let Some(all) = probes_of(&grid) else {
            return Err(reader.invalid(format_args!("no grid has {} probes", grid.resolution)));
        };
        WireError::check("probes of a grid", all as usize, limits.probes)?;
        if count == 0 || grid.first.checked_add(count).is_none_or(|end| end > all) {
            return Err(reader.invalid("there are no probes, or some outside of their grid"));
        }
        probes = probes.saturating_add(count as usize);
        WireError::check("probes of a lighting message", probes, limits.probes)?;
        Ok((grid, count as usize, reader.varint()?))
    };
    (0..count).map(grid).collect()
}

fn read_rect(reader: &mut Reader<'_>) -> Result<(PageId, TexelRect), WireError> {
    let page = PageId(read_u32(reader)?);
    let rect = TexelRect {
        x: read_u32(reader)?,
        y: read_u32(reader)?,
        width: read_u32(reader)?,
        height: read_u32(reader)?,
    };
    if is_rect(page, rect) {
        return Ok((page, rect));
    }
    let TexelRect { x, y, width, height } = rect;
    let page = page.0;
    Err(reader.invalid(format_args!("no page {page} has {width} x {height} texels at {x}, {y}")))
}

fn read_u32(reader: &mut Reader<'_>) -> Result<u32, WireError> {
    let number = reader.varint()?;
    number.try_into().map_err(|_| reader.invalid(format_args!("{number} is too large")))
}
