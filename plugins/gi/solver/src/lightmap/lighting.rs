//! Solves light for one state of the geometry, in slices.
//!
//! Two kinds of work alternate. *Growing* traces kept rays ([`Block`]). *Solving* answers for the
//! lights as they are: shadow rays where a light moved, then bounces between all patches through
//! few kept rays each, then one last gather through all kept rays at the texels and probes that are
//! shown. Noise of the few rays averages out in the last gather, whose every ray ends on another
//! patch.

use std::{f32::consts::PI, sync::Arc};

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::{
    closed::is_closed,
    direct::Direct,
    fill::FillPlan,
    grids::GridState,
    patches::Patches,
    raster::MeshTexels,
    sequence::unpack_direction,
    transport::{Block, Buried, FIRST_BLOCK, Origin},
};
use crate::{Scene, World};

/// Blocks that every patch has, not only texels that are shown; bounces use these.
const LOW_BLOCKS: usize = 2;
/// Rays of a probe's first block: its sphere is twice a hemisphere, and probes are few.
const FIRST_PROBE_BLOCK: u32 = 128;
/// Kept rays that one slice of growing traces.
const GROW_SLICE: usize = 1 << 16;
/// Shadow rays of one slice of solving.
const SHADOW_SLICE: usize = 1 << 18;
/// Kept rays that one slice of solving reads.
const GATHER_SLICE: usize = 1 << 24;
/// A bounce that changes irradiance by less than this part of the largest is the last.
const SETTLED: f32 = 2e-4;
/// From this many bounces on, all are followed, each solution starting from the one before.
const ALL_BOUNCES: u32 = 6;
/// A texel is buried if this part of its rays meets the inside of closed meshes, or backs near by.
const BURIED: f32 = 0.5;

/// What bounds the work.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    pub rays_per_texel: u32,
    pub rays_per_probe: u32,
    pub ray_memory: usize,
    pub bounces: u32,
    pub seed: u32,
}

/// The state of light in a world.
pub(crate) struct Lighting {
    pub world: World,
    pub patches: Patches,
    pub grids: Vec<GridState>,
    pub direct: Direct,
    /// For each texel shown: irradiance from other surfaces and the sky. Buried ones hold nothing.
    pub irradiance: Vec<Vec3>,
    /// For each texel shown: how far half of its rays disagree with all, in luminance.
    pub spread: Vec<f32>,
    /// How the texels of each receiver are spread over its rectangle.
    pub plans: Vec<FillPlan>,
    /// Kept rays traced so far, for measurements.
    pub traced: u64,
    /// Whether another solution for the same light would give the same.
    pub settled: bool,
    limits: Limits,
    closed: Vec<bool>,
    near: f32,
    blocks: Vec<Block>,
    buried: Vec<Buried>,
    valid: Vec<bool>,
    /// Receivers with buried texels.
    holes: Vec<usize>,
    /// For each patch: irradiance straight from the sky.
    sky: Vec<Vec3>,
    sky_stale: bool,
    /// For each patch: irradiance from other patches through its first rays.
    bounced: Vec<Vec3>,
    /// Radiance that leaves each patch, shifted by one: entry 0 is black.
    table: Vec<Vec4>,
    job: Option<Job>,
}

#[derive(Clone, Copy)]
enum Job {
    Direct,
    /// Gathers emission alone, where bounces are counted.
    Emission,
    Bounce(u32),
    Gather(usize),
    Grids(usize),
}

impl Lighting {
    /// Nothing is traced yet. `receivers` are instances of the world with their texels, `texel` the
    /// edge of a texel in metres.
    pub(crate) fn new(
        world: World,
        receivers: Vec<(u32, Arc<MeshTexels>)>,
        texel: f32,
        limits: Limits,
    ) -> Self {
        let closed = world.instances().iter().map(|i| is_closed(&i.mesh)).collect();
        let patches = Patches::new(&world, receivers, texel * 2.0);
        let fronts = patches.fronts;
        let mut lighting = Self {
            world,
            grids: Vec::new(),
            direct: Direct::default(),
            irradiance: vec![Vec3::ZERO; fronts],
            spread: vec![0.0; fronts],
            plans: Vec::new(),
            traced: 0,
            settled: true,
            limits,
            closed,
            near: texel * 0.5,
            blocks: Vec::new(),
            buried: vec![Buried::default(); fronts],
            valid: vec![true; fronts],
            holes: Vec::new(),
            sky: Vec::new(),
            sky_stale: true,
            bounced: Vec::new(),
            table: Vec::new(),
            job: None,
            patches,
        };
        lighting.plan();
        lighting
    }

    /// Takes lights and sky of a scene over; ask for a [`solve`](Self::start) afterwards.
    pub(crate) fn set_lights(&mut self, scene: &Scene) {
        self.direct.set_lights(&scene.lights);
        if self.world.sky != scene.sky {
            self.world.sky = scene.sky.clone();
            self.sky_stale = true;
        }
    }

    /// Takes materials over; `false` where geometry changes by them.
    pub(crate) fn refresh_materials(&mut self, scene: &Scene) -> bool {
        let same = self.world.refresh_materials(scene);
        if same {
            self.patches.refresh_materials(&self.world);
        }
        same
    }

    /// Begins with what an older state knew about the same texels, so that bounces converge sooner.
    pub(crate) fn start_from(&mut self, old: &Self) {
        self.bounced.resize(self.patches.len(), Vec3::ZERO);
        for receiver in &self.patches.receivers {
            let id = self.world.instances()[receiver.instance as usize].id;
            let same = old.patches.receivers.iter().find(|r| {
                old.world.instances()[r.instance as usize].id == id
                    && Arc::ptr_eq(&r.texels, &receiver.texels)
            });
            if let Some(same) = same {
                let count = receiver.texels.len();
                let (to, from) = (receiver.first as usize, same.first as usize);
                if old.bounced.len() >= from + count {
                    self.bounced[to..to + count].copy_from_slice(&old.bounced[from..from + count]);
                }
            }
        }
    }

    /// Rays a texel that the next solution can use.
    pub(crate) fn rays(&self) -> u32 {
        self.blocks.iter().filter(|b| b.origins() >= self.patches.fronts).map(|b| b.count).sum()
    }

    /// Whether there are kept rays enough for a first answer.
    pub(crate) fn is_ready(&self) -> bool {
        self.blocks.first().is_some_and(|b| b.origins() >= self.patches.len())
            && self.grids.iter().all(|g| g.rays() > 0)
    }

    /// Whether a solution is being worked on.
    pub(crate) fn is_solving(&self) -> bool {
        self.job.is_some()
    }

    /// Begins a solution for the lights as they are.
    pub(crate) fn start(&mut self) {
        self.job = Some(Job::Direct);
    }

    /// Traces one slice of kept rays. `None` if there is nothing left to trace, else whether
    /// a solution can become better by it now.
    pub(crate) fn grow(&mut self) -> Option<bool> {
        let fronts = self.patches.fronts;
        for index in 0..self.blocks.len() {
            let domain = if index < LOW_BLOCKS { self.patches.len() } else { fronts };
            let start = self.blocks[index].origins();
            if start < domain {
                let block = &mut self.blocks[index];
                let end = domain.min(start + (GROW_SLICE / block.count as usize).max(1));
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
                let end =
                    grid.origins.len().min(start + (GROW_SLICE / block.count as usize).max(1));
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

    /// Does one slice of solving. Returns whether the solution is complete.
    pub(crate) fn advance(&mut self) -> bool {
        match self.job {
            None => return false,
            Some(Job::Direct) => {
                if self.direct.advance(&self.world, &self.patches, SHADOW_SLICE) {
                    self.sum_sky();
                    self.bounced.resize(self.patches.len(), Vec3::ZERO);
                    let counted = self.limits.bounces < ALL_BOUNCES;
                    if counted {
                        self.bounced.fill(Vec3::ZERO);
                    }
                    if counted && self.patches.emission.iter().any(|e| *e != Vec3::ZERO) {
                        self.job = Some(Job::Emission);
                    } else {
                        self.fill_table();
                        self.job = Some(self.first_bounce());
                    }
                }
            }
            Some(Job::Emission) => {
                self.table.clear();
                self.table.push(Vec4::ZERO);
                self.table.extend(self.patches.emission.iter().map(|e| e.extend(0.0)));
                self.bounce();
                self.fill_table();
                self.job = Some(self.first_bounce());
            }
            Some(Job::Bounce(n)) => {
                let change = self.bounce();
                self.fill_table();
                self.settled = change < SETTLED || self.limits.bounces < ALL_BOUNCES;
                let last = n + 1 >= self.limits.bounces || change < SETTLED;
                self.job = Some(if last { Job::Gather(0) } else { Job::Bounce(n + 1) });
            }
            Some(Job::Gather(start)) => {
                let end = self.gather(start);
                self.job =
                    Some(if end < self.patches.fronts { Job::Gather(end) } else { Job::Grids(0) });
            }
            Some(Job::Grids(index)) => {
                if let Some(grid) = self.grids.get_mut(index) {
                    grid.solve(&self.table, &self.world.sky);
                    self.job = Some(Job::Grids(index + 1));
                } else {
                    self.job = None;
                    return true;
                }
            }
        }
        false
    }

    fn first_bounce(&self) -> Job {
        if self.limits.bounces > 1 { Job::Bounce(1) } else { Job::Gather(0) }
    }

    /// Radiance that leaves every patch, from what arrives at it.
    fn fill_table(&mut self) {
        let count = self.patches.len();
        self.table.resize(count + 1, Vec4::ZERO);
        let (patches, direct, sky, bounced) =
            (&self.patches, &self.direct, &self.sky, &self.bounced);
        self.table[1..].par_iter_mut().with_min_len(512).enumerate().for_each(|(i, out)| {
            let irradiance = direct.irradiance(i) + sky[i] + bounced[i];
            *out = (patches.albedo[i] / PI * irradiance + patches.emission[i]).extend(0.0);
        });
    }

    /// One bounce between all patches. Returns the largest change relative to the largest value.
    fn bounce(&mut self) -> f32 {
        let fronts = self.patches.fronts;
        let blocks: Vec<&Block> =
            self.blocks.iter().take(LOW_BLOCKS).filter(|b| b.origins() >= fronts).collect();
        let table = &self.table;
        let (change, largest) = self
            .bounced
            .par_iter_mut()
            .with_min_len(128)
            .enumerate()
            .map(|(i, bounced)| {
                let (mut sum, mut rays) = (Vec4::ZERO, 0);
                for block in blocks.iter().filter(|b| b.origins() > i) {
                    sum += block.gather(i, table);
                    rays += block.count;
                }
                let new = if rays == 0 { Vec3::ZERO } else { sum.truncate() * (PI / rays as f32) };
                let change = (new - *bounced).abs().max_element();
                *bounced = new;
                (change, new.max_element())
            })
            .reduce(|| (0.0_f32, 0.0_f32), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        for &receiver in &self.holes {
            let first = self.patches.receivers[receiver].first as usize;
            let plan = &self.plans[receiver];
            let mut padded = vec![Vec3::ZERO; (plan.width * plan.height) as usize];
            for (i, &at) in plan.place.iter().enumerate() {
                padded[at as usize] = self.bounced[first + i];
            }
            plan.apply(&mut padded);
            for (i, &at) in plan.place.iter().enumerate() {
                self.bounced[first + i] = padded[at as usize];
            }
        }
        if largest > 0.0 { change / largest } else { 0.0 }
    }

    /// The last gather for a slice of the texels that are shown. Returns its end.
    fn gather(&mut self, start: usize) -> usize {
        let fronts = self.patches.fronts;
        let blocks: Vec<&Block> = self.blocks.iter().filter(|b| b.origins() >= fronts).collect();
        let Some((last, before)) = blocks.split_last() else { return fronts };
        let rays_before: u32 = before.iter().map(|b| b.count).sum();
        let rays = rays_before + last.count;
        let end = fronts.min(start + (GATHER_SLICE / rays as usize).max(1));
        let (table, sky) = (&self.table, &self.sky);
        self.irradiance[start..end]
            .par_iter_mut()
            .zip(&mut self.spread[start..end])
            .with_min_len(32)
            .enumerate()
            .for_each(|(i, (irradiance, spread))| {
                let i = start + i;
                let old: Vec4 = before.iter().map(|b| b.gather(i, table)).sum();
                let new = last.gather(i, table);
                *irradiance = (old + new).truncate() * (PI / rays as f32) + sky[i];
                *spread = if rays_before == 0 {
                    luminance(*irradiance) * 0.2
                } else {
                    let halves = new / last.count as f32 - old / rays_before as f32;
                    luminance(halves.truncate()).abs() * PI * 0.5
                };
            });
        end
    }

    /// Irradiance from the sky at all patches, through the rays that met it.
    fn sum_sky(&mut self) {
        let count = self.patches.len();
        if !self.sky_stale && self.sky.len() == count {
            return;
        }
        self.sky_stale = false;
        self.sky.clear();
        self.sky.resize(count, Vec3::ZERO);
        if self.world.sky.is_black() {
            return;
        }
        let fronts = self.patches.fronts;
        let mut rays = vec![0_u32; count];
        for block in self.blocks.iter().filter(|b| b.origins() >= fronts) {
            rays[..block.origins()].iter_mut().for_each(|r| *r += block.count);
            for &(origin, packed) in &block.sky {
                self.sky[origin as usize] += self.world.sky.radiance(unpack_direction(packed));
            }
        }
        for (sky, rays) in self.sky.iter_mut().zip(rays) {
            *sky *= PI / rays.max(1) as f32;
        }
    }

    /// Decides which texels are inside of other geometry, and how rectangles are filled.
    fn find_buried(&mut self) {
        for (valid, buried) in self.valid.iter_mut().zip(&self.buried) {
            *valid = (buried.inside as f32) < BURIED * buried.rays.max(1) as f32;
        }
        self.plan();
    }

    fn plan(&mut self) {
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

    /// A receiver's padded rectangle of E / pi.
    pub(crate) fn rectangle(&self, receiver: usize) -> Vec<Vec3> {
        let plan = &self.plans[receiver];
        let first = self.patches.receivers[receiver].first as usize;
        let mut texels = vec![Vec3::ZERO; (plan.width * plan.height) as usize];
        for (i, &at) in plan.place.iter().enumerate() {
            texels[at as usize] = self.irradiance[first + i] / PI;
        }
        plan.apply(&mut texels);
        texels
    }

    /// Median over lit texels of the relative error that the halves of their rays suggest.
    pub(crate) fn relative_error(&self) -> f32 {
        let brightest = self.irradiance.iter().map(|e| luminance(*e)).fold(0.0, f32::max);
        let mut errors: Vec<f32> = self
            .irradiance
            .iter()
            .zip(&self.spread)
            .map(|(e, spread)| (luminance(*e), spread))
            .filter(|(e, _)| *e > brightest * 0.01)
            .map(|(e, spread)| spread / e)
            .collect();
        if errors.is_empty() {
            return 0.0;
        }
        let middle = errors.len() / 2;
        *errors.select_nth_unstable_by(middle, f32::total_cmp).1
    }

    /// Whether a texel that is shown lies free, not inside of other geometry.
    pub(crate) fn is_valid(&self, texel: usize) -> bool {
        self.valid[texel]
    }
}

pub(crate) fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
