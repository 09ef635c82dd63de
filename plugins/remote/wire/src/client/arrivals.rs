//! Light arrives in any order; what is older than what is there is dropped.

use std::collections::{BTreeMap, HashMap};

use farlight_gi_solver::{
    atlas::{PageId, TexelRect},
    scene::InstanceId,
    session::GridId,
};

use super::history::History;
use crate::{LightingMessage, Piece, WireError};

/// Edge of the blocks of texels whose newest message is remembered. Rectangles begin at multiples
/// of it, or else blocks at their edges count for both neighbours.
const BLOCK: u32 = 4;

/// Messages after which a grid counts as gone when memory is short.
const LONG: u64 = 10_000;

/// The newest message about everything that is shown.
#[derive(Debug, Default)]
pub(super) struct Arrivals {
    /// By page: rows of blocks.
    pages: BTreeMap<PageId, Vec<u64>>,
    placements: HashMap<InstanceId, u64>,
    grids: HashMap<(GridId, u32), u64>,
    /// The newest head (snapshot, quality).
    head: u64,
    history: History,
}

impl Arrivals {
    /// Drops what a message brings too late, and remembers the rest. `edge` is that of a page.
    pub(super) fn filter(
        &mut self,
        message: &mut LightingMessage,
        edge: u32,
        max_pages: u32,
        objects: usize,
    ) -> Result<(), WireError> {
        let sequence = message.sequence;
        for rect in message
            .tiles
            .iter()
            .map(|t| (t.page, t.rect))
            .chain(message.placements.iter().map(|p| (p.page, p.rect)))
        {
            let (page, TexelRect { x, y, width, height }) = rect;
            let fits = |from: u32, size: u32| from.checked_add(size).is_some_and(|end| end <= edge);
            if page.0 >= max_pages || !fits(x, width) || !fits(y, height) {
                return Err(WireError::invalid(
                    "a lighting message",
                    "texels outside of the pages",
                ));
            }
        }
        let count = (edge.div_ceil(BLOCK) as usize).pow(2);
        message.tiles.retain(|tile| {
            let blocks = self.pages.entry(tile.page).or_insert_with(|| vec![0; count]);
            if newest_block(blocks, edge, tile.rect) > sequence {
                return false;
            }
            blocks_of(edge, tile.rect).for_each(|block| blocks[block] = sequence);
            true
        });
        message.placements.retain(|p| newest(&mut self.placements, p.instance, sequence));
        message.refused.retain(|(id, _)| newest(&mut self.placements, *id, sequence));
        message.grids.retain(|g| newest(&mut self.grids, (g.grid, g.first), sequence));
        WireError::check("placements", self.placements.len(), objects)?;
        WireError::check("runs of probes", self.grids.len(), objects)?;
        Ok(())
    }

    /// What is shown of a piece, as a message brought it; see [`History`].
    pub(super) fn base(&self, piece: Piece, sequence: u64) -> Option<&[[u16; 3]]> {
        self.history.get(piece, sequence)
    }

    /// Remembers what is shown now. `edge` is that of a page, `probes` how many the client has.
    pub(super) fn keep(
        &mut self,
        message: &LightingMessage,
        edge: u32,
        max_pages: u32,
        probes: usize,
    ) {
        let texels = edge as usize * edge as usize * max_pages as usize;
        let all = texels.saturating_add(probes.saturating_mul(9));
        let (pages, grids) = (&self.pages, &self.grids);
        let is_shown = |piece: Piece, sequence: u64| match piece {
            Piece::Tile(page, rect) => {
                let blocks = pages.get(&page).map_or(&[][..], |blocks| blocks);
                newest_block(blocks, edge, rect) <= sequence
            }
            Piece::Probes(grid, first) => {
                // Of grids that have gone nothing new has come for long.
                let newest = grids.get(&(grid, first)).copied().unwrap_or(0);
                newest <= sequence && sequence + LONG > message.sequence
            }
        };
        let tiles = message.tiles.iter().map(|tile| (tile.piece(), &tile.texels[..]));
        let runs = message.grids.iter().map(|run| (run.piece(), run.probes.as_flattened()));
        for (piece, values) in tiles.chain(runs) {
            self.history.keep(message.sequence, piece, values, all, is_shown);
        }
    }

    /// The server has built on what a message brought of a piece.
    pub(super) fn built_on(&mut self, piece: Piece, sequence: u64) {
        self.history.forget_before(piece, sequence);
    }

    /// The server of a new connection builds on nothing that an older one brought.
    pub(super) fn reconnect(&mut self) {
        self.history = History::default();
    }

    /// Whether snapshot and quality of a message are the newest.
    pub(super) fn is_newest(&mut self, sequence: u64) -> bool {
        let newest = sequence >= self.head;
        self.head = self.head.max(sequence);
        newest
    }
}

/// The blocks that a rectangle touches.
fn blocks_of(edge: u32, rect: TexelRect) -> impl Iterator<Item = usize> {
    let row = edge.div_ceil(BLOCK);
    let columns = rect.x / BLOCK..(rect.x + rect.width).div_ceil(BLOCK);
    let rows = rect.y / BLOCK..(rect.y + rect.height).div_ceil(BLOCK);
    rows.flat_map(move |y| columns.clone().map(move |x| (y * row + x) as usize))
}

/// The number of the newest message about any of some texels.
fn newest_block(blocks: &[u64], edge: u32, rect: TexelRect) -> u64 {
    blocks_of(edge, rect).filter_map(|block| blocks.get(block).copied()).max().unwrap_or(0)
}

fn newest<K: std::hash::Hash + Eq>(seen: &mut HashMap<K, u64>, key: K, sequence: u64) -> bool {
    let entry = seen.entry(key).or_insert(0);
    let newest = *entry <= sequence;
    if newest {
        *entry = sequence;
    }
    newest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HalfTile;

    fn message(sequence: u64, rects: &[[u32; 4]]) -> LightingMessage {
        let tiles = rects.iter().map(|&[x, y, width, height]| {
            let rect = TexelRect { x, y, width, height };
            HalfTile { page: PageId(0), rect, texels: vec![[0; 3]; rect.area()] }
        });
        LightingMessage { sequence, tiles: tiles.collect(), ..Default::default() }
    }

    #[test]
    fn late_tiles_are_dropped_and_others_kept() {
        let mut arrivals = Arrivals::default();
        let mut left = |mut message: LightingMessage| {
            arrivals.filter(&mut message, 64, 1, 100).unwrap();
            message.tiles.iter().map(|t| t.rect.x).collect::<Vec<_>>()
        };
        assert_eq!(left(message(5, &[[0, 0, 32, 32]])), [0]);
        assert_eq!(left(message(3, &[[0, 0, 32, 32], [32, 0, 32, 32]])), [32]);
        assert_eq!(left(message(4, &[[16, 16, 8, 8]])), [] as [u32; 0], "inside of a newer one");
        assert_eq!(left(message(6, &[[0, 0, 32, 32], [32, 32, 32, 32]])), [0, 32]);
    }

    #[test]
    fn texels_outside_are_refused() {
        let mut arrivals = Arrivals::default();
        for rect in [[60, 0, 8, 8], [0, 60, 8, 8], [u32::MAX, 0, 8, 8]] {
            let mut message = LightingMessage {
                tiles: vec![HalfTile {
                    rect: TexelRect { x: rect[0], y: rect[1], width: rect[2], height: rect[3] },
                    ..Default::default()
                }],
                ..Default::default()
            };
            assert!(arrivals.filter(&mut message, 64, 1, 100).is_err(), "{rect:?}");
        }
        let mut message = message(1, &[[0, 0, 8, 8]]);
        message.tiles[0].page = PageId(1);
        assert!(arrivals.filter(&mut message, 64, 1, 100).is_err());
    }

    #[test]
    fn heads_go_forward() {
        let mut arrivals = Arrivals::default();
        assert!(arrivals.is_newest(2) && arrivals.is_newest(3) && !arrivals.is_newest(2));
    }
}
