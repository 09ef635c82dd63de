//! The encoding of light.
//!
//! # Format
//! Numbers are LEB128 unless said otherwise.
//!
//! 1. Sequence, snapshot, the three times in microseconds (`u32` each: what was measured doesn't change
//!    how long a message is, so a simulated line is the same on every machine).
//! 2. Quality: the relative error (`f32`), rays a texel, converged (a byte 0 or 1).
//! 3. The count of placements, and for each: instance, page, x, y, width, height.
//! 4. The count of refused receivers, and for each: instance, length of the text, text.
//! 5. The count of tiles, and for each: page, x, y, width, height, and by how much the number of the
//!    message that brought its base is smaller than this message's (0: none).
//! 6. The count of runs of probes, and for each: grid, resolution (three), first, count, and the same
//!    about its base.
//! 7. The length of what follows: nothing, or one arithmetic code with packed bits
//!    ([`codec`](crate::codec)) of all texels in the order of the tiles ([`tile`]) and all probes in
//!    the order of the runs ([`probe`]), and zeros.
//!
//! A tile or run may be coded beside a *base*: what the other side is known to have of the very piece,
//! by an older message. Otherwise it stands for itself. What is learned, is learned over all tiles of a
//! message and not beyond, since messages may be lost.
//!
//! # Exactness
//! Lossy within documented bounds: see [`step`] for texels and [`probe`] for probes.
//! [`LightingMessage::rounded`] is what arrives.

mod octave;
mod probe;
mod read;
mod step;
#[cfg(test)]
mod tests;
mod tile;

use farlight_gi_solver::{
    atlas::{PageId, TexelRect},
    session::Quality,
};

use crate::{
    HalfGrid, LightingMessage, Piece,
    codec::{BitCoder, RangeEncoder, Writer},
};
use probe::ProbeCoder;
use step::Step;
use tile::TileCoder;

/// Pages there may be.
const PAGES: u32 = 64;
/// Edge of the largest page.
const EDGE: u32 = 4096;
/// Refused receivers in one message, and bytes of a reason.
const REFUSED: usize = 4096;
const REASON: usize = 256;
/// Texels that a byte of the arithmetic code may stand for. Adaptive codes shrink black without
/// bound; the encoder appends zeros, so that a decoder takes no memory for what isn't there.
const TEXELS_PER_BYTE: usize = 64;
/// As how many texels a probe counts there.
const PROBE_TEXELS: usize = 8;

impl LightingMessage {
    /// Its encoding, compressed. Tiles, runs and placements that are not valid (see
    /// [`decode`](Self::decode)) are left out, reasons are cut off and times above 71 minutes too.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        self.clone().encode_beside(|_| None).0
    }

    /// Its encoding, and what will arrive. `base` answers what the other side has of a piece (nine
    /// coefficients a probe), if it is known, and the number of the message that brought it.
    #[must_use]
    pub fn encode_beside<'a>(
        self,
        base: impl Fn(Piece) -> Option<(u64, &'a [[u16; 3]])>,
    ) -> (Vec<u8>, Self) {
        let mut message = self.without_invalid();
        let sequence = message.sequence;
        let choose = |piece: Piece, values: &[[u16; 3]]| {
            let (number, known) = base(piece)?;
            let fits = number < sequence && known.len() == values.len();
            let good = match piece {
                _ if !fits => false,
                Piece::Tile(..) => tile::is_smoother_beside(values, known),
                Piece::Probes(..) => probe::is_smoother_beside(values, known),
            };
            good.then_some((sequence - number, known))
        };
        let tiles = message.tiles.iter().map(|tile| choose(tile.piece(), &tile.texels));
        let grids =
            message.grids.iter().map(|grid| choose(grid.piece(), grid.probes.as_flattened()));
        let (distances, bases): (Vec<u64>, Vec<_>) = tiles
            .chain(grids)
            .map(|base| (base.map_or(0, |(distance, _)| distance), base.map(|(_, known)| known)))
            .unzip();
        let mut code = Vec::new();
        let (texels, probes) = (message.texels(), message.probes());
        if texels + probes > 0 {
            let mut coder = RangeEncoder::new();
            message.code(&mut coder, &bases);
            code = coder.finish();
            code.resize(code.len().max(least_code(texels, probes)), 0);
        }
        let mut out = Writer::default();
        message.write_head(&mut out, &distances);
        out.bytes(&code);
        (out.finish(), message)
    }

    /// What arrives: [`decode`](Self::decode) of [`encode`](Self::encode).
    #[must_use]
    pub fn rounded(&self) -> Self {
        let mut message = self.clone().without_invalid();
        message.code(&mut RangeEncoder::new(), &[]);
        message
    }

    fn without_invalid(self) -> Self {
        let mut message = self;
        message.placements.retain(|p| is_rect(p.page, p.rect));
        message.tiles.retain(|t| is_rect(t.page, t.rect) && t.texels.len() == t.rect.area());
        message.grids.retain(|g| {
            let count = u32::try_from(g.probes.len()).unwrap_or(u32::MAX);
            let fits = |all| g.first.checked_add(count).is_some_and(|n| n <= all);
            count > 0 && probes_of(g).is_some_and(fits)
        });
        message.refused.truncate(REFUSED);
        for (_, reason) in &mut message.refused {
            if reason.len() > REASON {
                *reason = reason[..reason.floor_char_boundary(REASON)].into();
            }
        }
        message
    }

    /// Codes all texels and probes; they hold afterwards what the other side has. Tiles and then runs
    /// have bases in the same order, if any.
    fn code(&mut self, coder: &mut impl BitCoder, bases: &[Option<&[[u16; 3]]>]) {
        let step = Step::of(&self.quality);
        let mut bases = bases.iter().copied().chain(std::iter::repeat(None));
        if !self.tiles.is_empty() {
            let mut tiles = TileCoder::new(step);
            for (tile, base) in self.tiles.iter_mut().zip(bases.by_ref()) {
                tiles.code(coder, tile.rect.width as usize, &mut tile.texels, base);
            }
        }
        if !self.grids.is_empty() {
            let mut probes = ProbeCoder::new(step);
            for (grid, base) in self.grids.iter_mut().zip(bases) {
                let base = base.map(|base| base.as_chunks().0);
                probes.code(coder, grid.resolution, grid.first, &mut grid.probes, base);
            }
        }
    }

    fn texels(&self) -> usize {
        self.tiles.iter().map(|tile| tile.texels.len()).sum()
    }

    fn probes(&self) -> usize {
        self.grids.iter().map(|grid| grid.probes.len()).sum()
    }

    fn write_head(&self, out: &mut Writer, distances: &[u64]) {
        let Self { sequence, snapshot, times, quality, placements, refused, tiles, grids } = self;
        out.varint(*sequence);
        out.varint(snapshot.0);
        for time in [times.held, times.solve, times.encode] {
            out.u32(time.as_micros().try_into().unwrap_or(u32::MAX));
        }
        let Quality { relative_error, rays_per_texel, converged } = *quality;
        out.f32(if relative_error.is_finite() { relative_error } else { 0.0 });
        out.varint(rays_per_texel.into());
        out.u8(converged.into());
        out.count(placements.len());
        for placement in placements {
            out.varint(placement.instance.0);
            write_rect(out, placement.page, placement.rect);
        }
        out.count(refused.len());
        for (instance, reason) in refused {
            out.varint(instance.0);
            out.bytes(reason.as_bytes());
        }
        out.count(tiles.len());
        for (tile, distance) in tiles.iter().zip(distances) {
            write_rect(out, tile.page, tile.rect);
            out.varint(*distance);
        }
        out.count(grids.len());
        let distances = distances.iter().skip(tiles.len());
        for (HalfGrid { grid, resolution, first, probes }, distance) in grids.iter().zip(distances)
        {
            out.varint(grid.0);
            resolution.to_array().into_iter().for_each(|n| out.varint(n.into()));
            out.varint((*first).into());
            out.count(probes.len());
            out.varint(*distance);
        }
    }
}

fn write_rect(out: &mut Writer, page: PageId, rect: TexelRect) {
    for number in [page.0, rect.x, rect.y, rect.width, rect.height] {
        out.varint(number.into());
    }
}

/// Whether a rectangle lies on a page that can be.
fn is_rect(page: PageId, rect: TexelRect) -> bool {
    let fits = |from: u32, size: u32| size >= 1 && from <= EDGE && size <= EDGE - from;
    page.0 < PAGES && fits(rect.x, rect.width) && fits(rect.y, rect.height)
}

/// Probes of a whole grid, if that is a number.
fn probes_of(grid: &HalfGrid) -> Option<u32> {
    let [x, y, z] = grid.resolution.to_array();
    x.checked_mul(y)?.checked_mul(z).filter(|all| *all > 0)
}

/// Bytes that the code of so much light has at least.
fn least_code(texels: usize, probes: usize) -> usize {
    probes.saturating_mul(PROBE_TEXELS).saturating_add(texels).div_ceil(TEXELS_PER_BYTE)
}
