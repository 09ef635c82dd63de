//! Tracing rays that are kept.

use super::{LOW_BLOCKS, Lighting};
use crate::lightmap::{
    fill::FillPlan,
    transport::{Block, FIRST_BLOCK, Origin},
};

/// Rays of a probe's first block: its sphere is twice a hemisphere, and probes are few.
const FIRST_PROBE_BLOCK: u32 = 128;
/// Rays that one slice traces.
const SLICE: usize = 1 << 16;
/// A texel is buried if this part of its rays meets the inside of closed meshes, or backs near by.
const BURIED: f32 = 0.5;
/// It is also if this part of its rays meets backs that are not drawn, however far away.
const ENCLOSED: f32 = 0.8;

impl Lighting {
    /// Traces one slice of kept rays. `None` if there is nothing left to trace, else whether
    /// a solution can become better by it now.
    pub(crate) fn grow(&mut self) -> Option<bool> {
        let fronts = self.patches.fronts;
        for index in 0..self.blocks.len() {
            let domain = if index < LOW_BLOCKS { self.patches.len() } else { fronts };
            let start = self.blocks[index].origins();
            if start < domain {
                let block = &mut self.blocks[index];
                let end = domain.min(start + (SLICE / block.count as usize).max(1));
                let origins: Vec<Origin> = (start..end)
                    .map(|i| Origin::Surface(self.patches.position[i], self.patches.normal[i]))
                    .collect();
                let buried = block.trace(
                    &self.world,
                    &self.closed,
                    &mut self.patches,
                    &origins,
                    self.near,
                    self.limits.seed,
                );
                self.traced += (end - start) as u64 * u64::from(self.blocks[index].count);
                for (i, new) in (start..end.min(fronts)).zip(buried) {
                    let sum = &mut self.buried[i];
                    sum.rays += new.rays;
                    sum.inside += new.inside;
                    sum.hidden += new.hidden;
                }
                let done = end == domain && start < fronts;
                if done && index < LOW_BLOCKS {
                    self.find_buried();
                }
                self.sky_stale = true;
                return Some(done && self.is_ready());
            }
        }
        for grid in &mut self.grids {
            let Some(block) = grid.blocks.last_mut() else { continue };
            let start = block.origins();
            if start < grid.origins.len() {
                let end = grid.origins.len().min(start + (SLICE / block.count as usize).max(1));
                let buried = block.trace(
                    &self.world,
                    &self.closed,
                    &mut self.patches,
                    &grid.origins[start..end],
                    self.near,
                    self.limits.seed,
                );
                self.traced += (end - start) as u64 * u64::from(block.count);
                for (sum, new) in grid.buried[start..end].iter_mut().zip(buried) {
                    sum.rays += new.rays;
                    sum.inside += new.inside;
                    sum.back += new.back;
                }
                return Some(end == grid.origins.len());
            }
        }
        self.open_block().then_some(false)
    }

    /// Opens the block that is due next, whoever has the fewest rays first.
    fn open_block(&mut self) -> bool {
        let texel_rays: u32 = self.blocks.iter().map(|b| b.count).sum();
        let bytes: usize = self
            .blocks
            .iter()
            .chain(self.grids.iter().flat_map(|g| &g.blocks))
            .map(|b| b.met.len() * 4 + b.sky.len() * 8)
            .sum();
        let fits = |origins: usize, count: u32| {
            bytes + origins * count as usize * 4 <= self.limits.ray_memory
        };
        let next = |rays: u32, least: u32| if rays == 0 { (0, least) } else { (rays, rays) };
        for grid in &mut self.grids {
            let (first, count) = next(grid.blocks.iter().map(|b| b.count).sum(), FIRST_PROBE_BLOCK);
            if texel_rays > 0
                && (first < texel_rays || texel_rays >= self.limits.rays_per_texel)
                && first + count <= self.limits.rays_per_probe.max(FIRST_PROBE_BLOCK)
                && (first == 0 || fits(grid.origins.len(), count))
            {
                grid.blocks.push(Block::new(first, count));
                return true;
            }
        }
        let (first, count) = next(texel_rays, FIRST_BLOCK);
        if first == 0
            || (first + count <= self.limits.rays_per_texel
                && fits(self.patches.fronts, count)
                && self.patches.fronts > 0)
        {
            self.blocks.push(Block::new(first, count));
            return true;
        }
        false
    }

    /// Decides which texels are inside of other geometry, and how rectangles are filled.
    fn find_buried(&mut self) {
        for ((valid, buried), open) in self.valid.iter_mut().zip(&self.buried).zip(&self.open) {
            let rays = buried.rays.max(1) as f32;
            *valid = *open
                && (buried.inside as f32) < BURIED * rays
                && (buried.hidden as f32) < ENCLOSED * rays;
        }
        self.plan();
    }

    pub(super) fn plan(&mut self) {
        let ranges = self.patches.receivers.iter().map(|r| {
            let first = r.first as usize;
            (r, &self.valid[first..first + r.texels.len()])
        });
        self.plans = ranges.clone().map(|(r, valid)| FillPlan::new(&r.texels, valid)).collect();
        self.holes = ranges
            .enumerate()
            .filter(|(_, (_, valid))| valid.iter().any(|v| !v))
            .map(|(i, _)| i)
            .collect();
    }
}
