//! Groups of neighbouring texels that share what is known about light that was reflected more than once.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::{Layout, map::alike};
use crate::{Ray, World, lightmap::NONE};

/// The cell of each texel.
pub(super) struct Cells {
    /// Cell of each texel, or [`NONE`] for texels that answer for nothing.
    pub(super) of: Vec<u32>,
    /// How many cells there are.
    pub(super) count: usize,
    /// Edge of a full cell in texels.
    pub(super) edge: u32,
}

impl Cells {
    /// Squares of `edge` texels, cut where charts end, surfaces turn, or something stands between: light
    /// on one side of a thin wall says nothing about the other.
    pub(super) fn new(world: &World, layout: &Layout, edge: u32) -> Self {
        let mut squares: BTreeMap<(u32, u32, u32, u32), Vec<u32>> = BTreeMap::new();
        for (index, receiver) in layout.patches.receivers.iter().enumerate() {
            for (i, [x, y]) in receiver.texels.coords.iter().enumerate() {
                let texel = receiver.first + i as u32;
                if layout.answers(texel as usize) {
                    let square = (u32::from(*y) / edge, u32::from(*x) / edge);
                    let key = (index as u32, square.0, square.1, receiver.texels.chart[i]);
                    squares.entry(key).or_default().push(texel);
                }
            }
        }
        let squares: Vec<Vec<u32>> = squares.into_values().collect();
        let groups: Vec<Vec<Vec<u32>>> =
            squares.into_par_iter().map(|texels| connected_groups(world, layout, texels)).collect();
        let mut cells = Self { of: vec![NONE; layout.len()], count: 0, edge };
        for group in groups.into_iter().flatten() {
            for texel in group {
                cells.of[texel as usize] = cells.count as u32;
            }
            cells.count += 1;
        }
        cells
    }
}

fn connected_groups(world: &World, layout: &Layout, texels: Vec<u32>) -> Vec<Vec<u32>> {
    let mut groups: Vec<Vec<u32>> = Vec::new();
    for texel in texels {
        let normal = layout.patches.normal[texel as usize];
        let home = groups.iter_mut().find(|group| {
            let other = group[0] as usize;
            alike(layout.patches.normal[other], normal)
                && layout.connected(world, other, texel as usize)
        });
        match home {
            Some(group) => group.push(texel),
            None => groups.push(vec![texel]),
        }
    }
    groups
}

impl Layout {
    /// Whether nothing stands between the points of two texels of one chart.
    fn connected(&self, world: &World, a: usize, b: usize) -> bool {
        let lift = 0.3 / self.texels_per_metre;
        let [from, to] = [a, b].map(|i| self.patches.position[i] + self.patches.normal[i] * lift);
        !world.occluded(&Ray { t_max: 1.0, ..Ray::new(from, to - from) })
    }
}
