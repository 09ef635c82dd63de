//! Probes on grids: the same kept rays as texels, to all sides.

use glam::{UVec3, Vec4};
use rayon::prelude::*;

use super::{
    sequence::unpack_direction,
    sky::SkyTable,
    transport::{Block, Buried, Origin, space_direction},
};
use crate::{
    session::{GridId, ProbeGrid},
    sh::{ShRgb, sh_basis},
};

/// A probe more of whose rays than this meet the inside of closed meshes, or backs near by, or than
/// [`ALL_BACK`] backs of any kind, is inside of something.
const INSIDE: f32 = 0.25;
const ALL_BACK: f32 = 0.6;

/// A probe grid with its rays and its solution.
pub(crate) struct GridState {
    pub id: GridId,
    pub grid: ProbeGrid,
    pub origins: Vec<Origin>,
    pub blocks: Vec<Block>,
    pub buried: Vec<Buried>,
    pub result: Vec<ShRgb>,
    /// What was published last.
    pub shown: Vec<ShRgb>,
}

impl GridState {
    pub(crate) fn new(id: GridId, grid: ProbeGrid) -> Self {
        let resolution = grid.resolution.max(UVec3::ONE);
        let mut origins = Vec::new();
        for z in 0..resolution.z {
            for y in 0..resolution.y {
                for x in 0..resolution.x {
                    let cell = (UVec3::new(x, y, z).as_vec3() + 0.5) / resolution.as_vec3() - 0.5;
                    origins.push(Origin::Space(grid.transform.transform_point3(cell)));
                }
            }
        }
        let grid = ProbeGrid { resolution, ..grid };
        let count = origins.len();
        Self {
            id,
            grid,
            origins,
            blocks: Vec::new(),
            buried: vec![Buried::default(); count],
            result: vec![ShRgb::ZERO; count],
            shown: Vec::new(),
        }
    }

    /// Where the probes are.
    pub(crate) fn positions(&self) -> Vec<glam::Vec3> {
        let position = |origin: &Origin| match *origin {
            Origin::Space(position) | Origin::Surface(position, _) => position,
        };
        self.origins.iter().map(position).collect()
    }

    /// Forgets the rays, after geometry changed.
    pub(crate) fn invalidate(&mut self) {
        self.blocks.clear();
        self.buried.fill(Buried::default());
    }

    /// Rays a probe that are complete.
    pub(crate) fn rays(&self) -> u32 {
        self.complete().map(|b| b.count).sum()
    }

    fn complete(&self) -> impl Iterator<Item = &Block> {
        self.blocks.iter().filter(|b| b.origins() == self.origins.len())
    }

    /// Solves all probes from the radiance that leaves the patches, and that of the sky unless it is left
    /// out.
    pub(crate) fn solve(&mut self, table: &[Vec4], sky: Option<&SkyTable>) {
        let rays = self.rays();
        if rays == 0 {
            return;
        }
        let blocks: Vec<&Block> = self.complete().collect();
        let basis: Vec<[f32; 9]> = (0..rays).map(|i| sh_basis(space_direction(i))).collect();
        let weight = 4.0 * std::f32::consts::PI / rays as f32;
        let mut result = vec![ShRgb::ZERO; self.origins.len()];
        result.par_iter_mut().with_min_len(8).enumerate().for_each(|(i, sh)| {
            let mut sums = [Vec4::ZERO; 9];
            for block in &blocks {
                let count = block.count as usize;
                let met = &block.met[i * count..(i + 1) * count];
                for (&met, basis) in met.iter().zip(&basis[block.first as usize..]) {
                    if met != 0 {
                        let radiance = table[met as usize];
                        for (sum, y) in sums.iter_mut().zip(basis) {
                            *sum += radiance * *y;
                        }
                    }
                }
                if let Some(sky) = sky.filter(|sky| !sky.is_black()) {
                    let start = block.sky.partition_point(|(origin, _)| (*origin as usize) < i);
                    for &(_, packed) in
                        block.sky[start..].iter().take_while(|(o, _)| *o as usize == i)
                    {
                        let radiance = sky.radiance(packed).extend(0.0);
                        for (sum, y) in sums.iter_mut().zip(sh_basis(unpack_direction(packed))) {
                            *sum += radiance * y;
                        }
                    }
                }
            }
            *sh = ShRgb(sums.map(|s| s.truncate() * weight));
        });
        self.result = result;
        self.fill_buried();
    }

    /// Gives probes inside of something the mean of their valid neighbours, from near to far.
    pub(crate) fn fill_buried(&mut self) {
        let mut valid: Vec<bool> = self
            .buried
            .iter()
            .map(|b| {
                let rays = b.rays as f32;
                b.inside as f32 <= INSIDE * rays && b.back as f32 <= ALL_BACK * rays
            })
            .collect();
        let size = self.grid.resolution.as_ivec3();
        let index = |p: glam::IVec3| (p.x + size.x * (p.y + size.y * p.z)) as usize;
        loop {
            let mut filled = Vec::new();
            for i in (0..valid.len()).filter(|&i| !valid[i]) {
                let n = i as i32;
                let p = glam::IVec3::new(n % size.x, n / size.x % size.y, n / (size.x * size.y));
                let (mut sum, mut weight) = (ShRgb::ZERO, 0.0);
                for d in (0..27).map(|k| glam::IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)) {
                    let q = p + d;
                    if q.cmplt(glam::IVec3::ZERO).any() || q.cmpge(size).any() || !valid[index(q)] {
                        continue;
                    }
                    let w = 1.0 / d.as_vec3().length_squared();
                    sum += self.result[index(q)] * w;
                    weight += w;
                }
                if weight > 0.0 {
                    filled.push((i, sum * (1.0 / weight)));
                }
            }
            if filled.is_empty() {
                return;
            }
            for (i, sh) in filled {
                self.result[i] = sh;
                valid[i] = true;
            }
        }
    }

    /// Whether the solution differs from what is shown by more than `tolerance` of the largest
    /// coefficient; if so it counts as shown from now on.
    pub(crate) fn publish(&mut self, tolerance: f32) -> bool {
        let largest = self.result.iter().map(|sh| sh.0[0].abs().max_element()).fold(0.0, f32::max);
        let differs = self.shown.len() != self.result.len()
            || self.result.iter().zip(&self.shown).any(|(a, b)| {
                let scale = a.0[0].abs().max_element().max(largest * 0.01);
                a.0.iter().zip(&b.0).any(|(a, b)| (*a - *b).abs().max_element() > tolerance * scale)
            });
        if differs {
            self.shown.clone_from(&self.result);
        }
        differs
    }
}
