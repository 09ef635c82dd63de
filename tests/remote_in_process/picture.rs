//! What a game would show: texels by receiver, probes by grid.

use std::collections::BTreeMap;

use farlight::gi::{
    EncodedGrid, GiUpdate,
    solver::{
        atlas::{PageId, TexelRect},
        scene::InstanceId,
        session::{GridId, Placement, Quality, SnapshotId},
    },
};
use half::f16;

/// Bytes of a texel.
const TEXEL: usize = 8;
/// Edge of the pages of the tests.
const EDGE: usize = 64;

#[derive(Clone, Default)]
pub(crate) struct Picture {
    pages: BTreeMap<PageId, Vec<[f32; 3]>>,
    placements: BTreeMap<InstanceId, Placement>,
    grids: BTreeMap<GridId, EncodedGrid>,
    pub(crate) snapshot: SnapshotId,
    pub(crate) quality: Quality,
    pub(crate) updates: usize,
}

fn halves(bytes: &[u8]) -> [f32; 3] {
    [0, 2, 4].map(|i| f16::from_le_bytes([bytes[i], bytes[i + 1]]).to_f32())
}

impl Picture {
    /// Takes an update over.
    pub(crate) fn show(&mut self, update: GiUpdate) {
        self.updates += 1;
        assert!(update.snapshot >= self.snapshot, "snapshots never go back");
        self.snapshot = update.snapshot;
        self.quality = update.quality;
        assert_eq!(update.refused, []);
        self.placements.extend(update.placements.iter().map(|p| (p.instance, *p)));
        for tile in &update.tiles {
            let page = self.pages.entry(tile.page).or_insert_with(|| vec![[0.0; 3]; EDGE * EDGE]);
            let TexelRect { x, y, width, .. } = tile.rect;
            for (i, texel) in tile.texels.chunks_exact(TEXEL).enumerate() {
                let (column, row) =
                    (x as usize + i % width as usize, y as usize + i / width as usize);
                page[row * EDGE + column] = halves(texel);
            }
        }
        self.grids.extend(update.grids.into_iter().map(|grid| (grid.grid, grid)));
    }

    /// The texels of a receiver.
    fn receiver(&self, id: InstanceId) -> Vec<[f32; 3]> {
        let Placement { page, rect, .. } = self.placements[&id];
        let page = &self.pages[&page];
        let rows = rect.y as usize..(rect.y + rect.height) as usize;
        rows.flat_map(|row| {
            let start = row * EDGE + rect.x as usize;
            page[start..start + rect.width as usize].iter().copied()
        })
        .collect()
    }

    /// Mean difference of texels and probes from a picture of the same scene, in units of that
    /// picture's mean. 1 if something isn't there at all.
    pub(crate) fn error(&self, right: &Self) -> f32 {
        if self.placements.len() != right.placements.len() || self.grids.len() != right.grids.len()
        {
            return 1.0;
        }
        let texels = right.placements.keys().map(|id| (self.receiver(*id), right.receiver(*id)));
        let cubes = |grid: &EncodedGrid| grid.texels.chunks_exact(TEXEL).map(halves).collect();
        let grids = right.grids.iter().map(|(id, grid)| (cubes(&self.grids[id]), cubes(grid)));
        let (mut difference, mut sum) = (0.0, 0.0);
        for (found, expected) in texels.chain(grids) {
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                difference += (found - expected).abs();
                sum += expected;
            }
        }
        difference / sum
    }
}
