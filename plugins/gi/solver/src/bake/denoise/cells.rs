//! A uniform grid over points in the world.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

/// Points by the cells they lie in.
pub(super) struct Cells {
    edge: f32,
    /// Points in the order of their cells.
    pub(super) order: Vec<u32>,
    /// Each cell and where its points start in `order`; an end.
    cells: Vec<(IVec3, u32)>,
    index: HashMap<IVec3, u32>,
}

impl Cells {
    /// Puts the points of `wanted` into cells with edges of `edge` (above 0).
    pub(super) fn new(points: &[Vec3], wanted: &[bool], edge: f32) -> Self {
        // Far from the overflow of neighbours' coordinates.
        let limit = Vec3::splat(1e9);
        let cell = |p: Vec3| (p / edge).floor().clamp(-limit, limit).as_ivec3();
        let mut keyed: Vec<([i32; 3], u32)> = (0..points.len())
            .filter(|&i| wanted[i])
            .map(|i| (cell(points[i]).to_array(), i as u32))
            .collect();
        keyed.sort_unstable();
        let mut cells: Vec<(IVec3, u32)> = Vec::new();
        for (at, (key, _)) in keyed.iter().enumerate() {
            let key = IVec3::from_array(*key);
            if cells.last().is_none_or(|last| last.0 != key) {
                cells.push((key, at as u32));
            }
        }
        let index = cells.iter().enumerate().map(|(i, c)| (c.0, i as u32)).collect();
        cells.push((IVec3::MAX, keyed.len() as u32));
        Self { edge, order: keyed.into_iter().map(|k| k.1).collect(), cells, index }
    }

    /// How many cells hold points.
    pub(super) fn len(&self) -> usize {
        self.cells.len() - 1
    }

    /// The points of a cell.
    pub(super) fn points(&self, cell: usize) -> &[u32] {
        &self.order[self.cells[cell].1 as usize..self.cells[cell + 1].1 as usize]
    }

    /// Collects the points of all cells that come within `radius` of a cell.
    pub(super) fn around(&self, cell: usize, radius: f32, found: &mut Vec<u32>) {
        found.clear();
        let (at, reach) = (self.cells[cell].0, (radius / self.edge).ceil() as i32);
        for x in -reach..=reach {
            for y in -reach..=reach {
                for z in -reach..=reach {
                    if let Some(&cell) = self.index.get(&(at + IVec3::new(x, y, z))) {
                        found.extend_from_slice(self.points(cell as usize));
                    }
                }
            }
        }
    }
}
