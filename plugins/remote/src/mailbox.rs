//! Light that waits for the game: a few updates, and what comes on top is merged. A game that does
//! not draw neither piles light up nor misses any.

use std::collections::{HashSet, VecDeque};

use farlight_gi::{
    EncodedTile, GiUpdate, UpdateTimes,
    solver::{atlas::TexelRect, scene::InstanceId},
};

/// Updates that wait as they came.
const MAX_WAITING: usize = 4;
/// Bytes of a texel.
const TEXEL: usize = 8;

/// Updates that wait, oldest first.
#[derive(Debug, Default)]
pub(crate) struct Waiting(VecDeque<GiUpdate>);

impl Waiting {
    pub(crate) fn pop(&mut self) -> Option<GiUpdate> {
        self.0.pop_front()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn push(&mut self, update: GiUpdate) {
        self.0.push_back(update);
    }

    /// Takes the newest update out if there is no room for one more: merge with it, and push that.
    pub(crate) fn pop_to_merge(&mut self) -> Option<GiUpdate> {
        (self.0.len() >= MAX_WAITING).then(|| self.0.pop_back()).flatten()
    }
}

/// Adds a newer update to an older one. What it replaces is gone, so the sum is never larger than
/// all pages, all probes and all receivers together.
pub(crate) fn merge(older: &mut GiUpdate, newer: GiUpdate) {
    older.snapshot = older.snapshot.max(newer.snapshot);
    older.quality = newer.quality;
    older.times = newer_times(&older.times, &newer.times);

    let known = newer.placements.iter().map(|p| p.instance);
    let known: HashSet<InstanceId> = known.chain(newer.refused.iter().map(|r| r.0)).collect();
    older.placements.retain(|placement| !known.contains(&placement.instance));
    older.refused.retain(|(instance, _)| !known.contains(instance));
    older.placements.extend(newer.placements);
    older.refused.extend(newer.refused);

    for grid in newer.grids {
        match older.grids.iter_mut().find(|old| old.grid == grid.grid) {
            Some(old) => *old = grid,
            None => older.grids.push(grid),
        }
    }
    for tile in newer.tiles {
        cut_out(&mut older.tiles, &tile);
        older.tiles.push(tile);
    }
}

fn newer_times(older: &UpdateTimes, newer: &UpdateTimes) -> UpdateTimes {
    UpdateTimes {
        send: newer.send.or(older.send),
        solve: newer.solve.or(older.solve),
        encode: newer.encode.or(older.encode),
        transfer: newer.transfer.or(older.transfer),
        decode: newer.decode.or(older.decode),
    }
}

/// Takes the place of `tile` out of all tiles.
fn cut_out(tiles: &mut Vec<EncodedTile>, tile: &EncodedTile) {
    let mut pieces = Vec::new();
    tiles.retain(|old| {
        let touched = old.page == tile.page && old.rect.overlaps(&tile.rect);
        if touched {
            pieces.extend(around(old, &tile.rect));
        }
        !touched
    });
    tiles.extend(pieces);
}

/// What is left of a tile outside of a hole that overlaps it: above, below, left, right.
fn around(tile: &EncodedTile, hole: &TexelRect) -> Vec<EncodedTile> {
    let TexelRect { x, y, width, height } = tile.rect;
    let (right, bottom) = (x + width, y + height);
    let (hole_top, hole_bottom) = (hole.y.max(y), (hole.y + hole.height).min(bottom));
    let (hole_left, hole_right) = (hole.x.max(x), (hole.x + hole.width).min(right));
    [
        (x, right, y, hole_top),
        (x, right, hole_bottom, bottom),
        (x, hole_left, hole_top, hole_bottom),
        (hole_right, right, hole_top, hole_bottom),
    ]
    .into_iter()
    .filter(|(left, right, top, bottom)| left < right && top < bottom)
    .map(|(left, right, top, bottom)| {
        let rect = TexelRect { x: left, y: top, width: right - left, height: bottom - top };
        part(tile, rect)
    })
    .collect()
}

/// A part of a tile.
fn part(tile: &EncodedTile, rect: TexelRect) -> EncodedTile {
    let mut texels = Vec::with_capacity(rect.area() * TEXEL);
    for row in rect.y - tile.rect.y..rect.y - tile.rect.y + rect.height {
        let start = row as usize * tile.rect.width as usize + (rect.x - tile.rect.x) as usize;
        let row = start * TEXEL..(start + rect.width as usize) * TEXEL;
        texels.extend_from_slice(tile.texels.get(row).unwrap_or_default());
    }
    EncodedTile { page: tile.page, rect, texels }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use farlight_gi::{
        EncodedGrid,
        solver::{
            atlas::PageId,
            session::{GridId, Placement, SnapshotId},
        },
    };

    use super::*;

    const EDGE: u32 = 64;

    fn tile(rect: TexelRect, value: u16) -> EncodedTile {
        EncodedTile::from_half_bits(PageId(0), rect, &vec![[value; 3]; rect.area()])
    }

    /// Writes tiles into a page in their order.
    fn paint(page: &mut [u16], tiles: &[EncodedTile]) {
        for tile in tiles {
            let TexelRect { x, y, width, .. } = tile.rect;
            for (i, texel) in tile.texels.chunks_exact(TEXEL).enumerate() {
                let (column, row) = (x + i as u32 % width, y + i as u32 / width);
                page[(row * EDGE + column) as usize] = u16::from_le_bytes([texel[0], texel[1]]);
            }
        }
    }

    /// Random numbers that repeat.
    fn random(state: &mut u32, below: u32) -> u32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 8) % below
    }

    #[test]
    fn merged_tiles_show_the_same_and_never_more_than_a_page() {
        let mut state = 1;
        let page = || vec![0; (EDGE * EDGE) as usize];
        let (mut expected, mut found) = (page(), page());
        let mut merged = GiUpdate::default();
        for value in 1..500 {
            let tiles = (0..3).map(|_| {
                let (x, y) = (random(&mut state, EDGE), random(&mut state, EDGE));
                let width = 1 + random(&mut state, (EDGE - x).min(40));
                let height = 1 + random(&mut state, (EDGE - y).min(40));
                tile(TexelRect { x, y, width, height }, value)
            });
            let update = GiUpdate { tiles: tiles.collect(), ..Default::default() };
            paint(&mut expected, &update.tiles);
            merge(&mut merged, update);
            let texels: usize = merged.tiles.iter().map(|t| t.rect.area()).sum();
            assert!(texels <= (EDGE * EDGE) as usize, "{texels}");
            assert!(merged.tiles.iter().all(|t| t.texels.len() == t.rect.area() * TEXEL));
        }
        // Tiles don't overlap, so their order doesn't matter.
        merged.tiles.reverse();
        paint(&mut found, &merged.tiles);
        assert!(expected == found);
    }

    #[test]
    fn the_newest_of_everything_else_stays() {
        let rect = |x| TexelRect { x, y: 0, width: 1, height: 1 };
        let place = |id, x| Placement { instance: InstanceId(id), page: PageId(0), rect: rect(x) };
        let grid = |id, byte| EncodedGrid {
            grid: GridId(id),
            resolution: Default::default(),
            texels: vec![byte],
        };
        let mut older = GiUpdate {
            snapshot: SnapshotId(3),
            placements: vec![place(1, 1), place(2, 2), place(3, 3)],
            refused: vec![(InstanceId(4), "full".into()), (InstanceId(5), "full".into())],
            grids: vec![grid(1, 1), grid(2, 1)],
            times: UpdateTimes { send: Some(Duration::from_millis(1)), ..Default::default() },
            ..Default::default()
        };
        let newer = GiUpdate {
            snapshot: SnapshotId(2),
            placements: vec![place(2, 9), place(4, 4)],
            refused: vec![(InstanceId(3), "no".into())],
            grids: vec![grid(2, 2), grid(3, 2)],
            ..Default::default()
        };
        merge(&mut older, newer);
        assert_eq!(older.snapshot, SnapshotId(3));
        assert_eq!(older.placements, [place(1, 1), place(2, 9), place(4, 4)]);
        let refused: Vec<_> = older.refused.iter().map(|(id, _)| id.0).collect();
        assert_eq!(refused, [5, 3]);
        let grids: Vec<_> = older.grids.iter().map(|g| (g.grid.0, g.texels[0])).collect();
        assert_eq!(grids, [(1, 1), (2, 2), (3, 2)]);
        assert!(older.times.send.is_some());
    }

    #[test]
    fn a_few_updates_wait_as_they_came() {
        let mut waiting = Waiting::default();
        for snapshot in 1..=4 {
            assert!(waiting.pop_to_merge().is_none());
            waiting.push(GiUpdate { snapshot: SnapshotId(snapshot), ..Default::default() });
        }
        let newest = waiting.pop_to_merge().unwrap();
        assert_eq!(newest.snapshot, SnapshotId(4));
        waiting.push(newest);
        let order: Vec<_> = std::iter::from_fn(|| waiting.pop()).map(|u| u.snapshot.0).collect();
        assert_eq!(order, [1, 2, 3, 4]);
    }
}
