//! The newest texels of all pages, as disjoint tiles.

use std::collections::BTreeMap;

use farlight_gi_solver::atlas::{PageId, TexelRect};

use crate::{HalfTile, Piece};

/// Edge of the cells by which tiles are found.
const CELL: u32 = 32;

/// Tiles by number; a number is used again when its tile was replaced.
#[derive(Debug, Default)]
pub(super) struct Tiles {
    tiles: Vec<Option<HalfTile>>,
    free: Vec<u32>,
    /// Tiles that touch a cell.
    cells: BTreeMap<(PageId, u32, u32), Vec<u32>>,
}

impl Tiles {
    /// Puts a tile in. Answers its number if it differs from what was there, and the numbers and
    /// names of tiles that it overlapped and that are gone.
    pub(super) fn insert(&mut self, tile: HalfTile) -> (Option<u32>, Vec<(u32, Piece)>) {
        let near = self.near(&tile);
        if let Some(same) = near.iter().find(|i| self.get(**i).is_some_and(|t| t.rect == tile.rect))
        {
            // Tiles don't overlap, so nothing else can be here.
            let slot = &mut self.tiles[*same as usize];
            let differs = slot.as_ref() != Some(&tile);
            *slot = Some(tile);
            return (differs.then_some(*same), Vec::new());
        }
        let overlapped: Vec<(u32, Piece)> = near
            .into_iter()
            .filter_map(|i| Some((i, self.get(i)?)))
            .filter(|(_, other)| other.rect.overlaps(&tile.rect))
            .map(|(i, other)| (i, other.piece()))
            .collect();
        overlapped.iter().for_each(|(i, _)| self.remove(*i));
        let index = self.free.pop().unwrap_or(self.tiles.len() as u32);
        for cell in cells(tile.page, &tile.rect) {
            self.cells.entry(cell).or_default().push(index);
        }
        if index as usize == self.tiles.len() {
            self.tiles.push(Some(tile));
        } else {
            self.tiles[index as usize] = Some(tile);
        }
        (Some(index), overlapped)
    }

    pub(super) fn get(&self, index: u32) -> Option<&HalfTile> {
        self.tiles.get(index as usize)?.as_ref()
    }

    fn near(&self, tile: &HalfTile) -> Vec<u32> {
        let mut near: Vec<u32> = cells(tile.page, &tile.rect)
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .copied()
            .collect();
        near.sort_unstable();
        near.dedup();
        near
    }

    fn remove(&mut self, index: u32) {
        let Some(tile) = self.tiles.get_mut(index as usize).and_then(Option::take) else { return };
        for cell in cells(tile.page, &tile.rect) {
            if let Some(list) = self.cells.get_mut(&cell) {
                list.retain(|i| *i != index);
            }
        }
        self.free.push(index);
    }
}

fn cells(page: PageId, rect: &TexelRect) -> impl Iterator<Item = (PageId, u32, u32)> {
    let columns = rect.x / CELL..(rect.x + rect.width).div_ceil(CELL);
    let rows = rect.y / CELL..(rect.y + rect.height).div_ceil(CELL);
    rows.flat_map(move |y| columns.clone().map(move |x| (page, y, x)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(rect: [u32; 4], value: u16) -> HalfTile {
        let [x, y, width, height] = rect;
        let rect = TexelRect { x, y, width, height };
        HalfTile { page: PageId(0), rect, texels: vec![[value; 3]; rect.area()] }
    }

    #[test]
    fn tiles_stay_disjoint() {
        let mut tiles = Tiles::default();
        let (a, gone) = tiles.insert(tile([0, 0, 32, 32], 1));
        assert!(gone.is_empty());
        assert_eq!(tiles.insert(tile([0, 0, 32, 32], 1)), (None, vec![]), "nothing changed");
        assert_eq!(tiles.insert(tile([0, 0, 32, 32], 2)), (a, vec![]));
        let (b, _) = tiles.insert(tile([32, 0, 20, 32], 1));
        let (c, gone) = tiles.insert(tile([16, 16, 32, 8], 3));
        let gone: Vec<u32> = gone.into_iter().map(|(index, _)| index).collect();
        assert_eq!(gone, [a.unwrap(), b.unwrap()]);
        assert_eq!(tiles.tiles.iter().flatten().count(), 1);
        assert_eq!(tiles.get(c.unwrap()), Some(&tile([16, 16, 32, 8], 3)));
        let (d, gone) = tiles.insert(tile([0, 0, 16, 16], 1));
        assert!(gone.is_empty() && d != c);
        assert!(tiles.tiles.len() <= 2, "numbers are used again");
    }
}
