//! Solving for the lights as they are.

use std::f32::consts::PI;

use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::{LOW_BLOCKS, Lighting, luminance};
use crate::{lightmap::transport::Block, scene::DirectSky};

/// Shadow rays of one slice.
const SHADOW_SLICE: usize = 1 << 18;
/// Kept rays that one slice reads.
const GATHER_SLICE: usize = 1 << 24;
/// A patch is still changing if a bounce changes its irradiance by more than this part of it.
const ENOUGH: f32 = 5e-3;
/// The same where there is nothing else to do than to come to the end.
const SETTLED: f32 = 5e-4;
/// So small a part of the patches may be changing when bounces end: light between two white
/// surfaces that nearly touch takes for ever to come to rest, and matters to nobody else.
const STRAGGLERS: f32 = 5e-3;
/// So many solutions follow at most, for the same light, until bounces have come to the end.
const MOST_POLISHES: u32 = 3;
/// Patches darker than this part of the brightest do not hold anything up.
const DARK: f32 = 2e-3;
/// From this many bounces on, all are followed, each solution starting from the one before.
const ALL_BOUNCES: u32 = 6;
/// Most steps towards all bounces in one solution.
const MOST_STEPS: u32 = 32;

/// What is done next.
#[derive(Clone, Copy)]
pub(super) enum Job {
    Direct,
    /// Gathers emission alone, where bounces are counted.
    Emission,
    Bounce(u32),
    Gather(usize),
    Grids(usize),
}

impl Lighting {
    /// Does one slice of solving. Returns whether the solution is complete.
    pub(crate) fn advance(&mut self) -> bool {
        match self.job {
            None => return false,
            Some(Job::Direct) => {
                if self.direct.advance(&self.world, &self.patches, SHADOW_SLICE) {
                    self.sum_sky();
                    self.bounced.resize(self.patches.len(), Vec3::ZERO);
                    self.sum_arriving();
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
                let changing = self.bounce();
                self.fill_table();
                let counted = self.limits.bounces < ALL_BOUNCES;
                let most = if counted { self.limits.bounces } else { MOST_STEPS };
                let goal = if self.polishes > 0 { changing.1 } else { changing.0 };
                let ended = !counted && goal <= STRAGGLERS;
                self.settled =
                    counted || changing.1 <= STRAGGLERS || self.polishes >= MOST_POLISHES;
                let last = n + 1 >= most || ended;
                self.job = Some(if last { Job::Gather(0) } else { Job::Bounce(n + 1) });
            }
            Some(Job::Gather(start)) => {
                let end = self.gather(start);
                self.job =
                    Some(if end < self.patches.fronts { Job::Gather(end) } else { Job::Grids(0) });
            }
            Some(Job::Grids(index)) => {
                if let Some(grid) = self.grids.get_mut(index) {
                    let included = self.direct_sky == DirectSky::Included;
                    grid.solve(&self.table, included.then_some(&self.sky_table));
                    self.job = Some(Job::Grids(index + 1));
                } else {
                    self.job = None;
                    self.refined.clear();
                    self.answered = true;
                    self.finish();
                    return true;
                }
            }
        }
        false
    }

    /// What arrives straight from the lights at each patch. Bounces start from those of the solution
    /// before, scaled by how much more light there is now.
    fn sum_arriving(&mut self) {
        let count = self.patches.len();
        self.arriving.resize(count, Vec3::ZERO);
        let (direct, sky) = (&self.direct, &self.sky);
        self.arriving
            .par_iter_mut()
            .with_min_len(512)
            .enumerate()
            .for_each(|(i, out)| *out = direct.irradiance(i) + sky[i]);
        // One after the other, so that rounding does not depend on the number of threads.
        let mut source = DVec3::ZERO;
        for (i, arriving) in self.arriving.iter().enumerate() {
            let leaving = self.patches.albedo[i] / PI * *arriving + self.patches.emission[i];
            source += leaving.as_dvec3();
        }
        let source = source.as_vec3();
        let ratio = source / self.source;
        let scale = Vec3::from_array(
            ratio.to_array().map(|r| if r.is_finite() { r.min(8.0) } else { 1.0 }),
        );
        if scale != Vec3::ONE {
            self.bounced.par_iter_mut().with_min_len(4096).for_each(|b| *b *= scale);
        }
        self.source = source;
    }

    fn first_bounce(&self) -> Job {
        if self.limits.bounces > 1 { Job::Bounce(1) } else { Job::Gather(0) }
    }

    /// Radiance that leaves every patch, from what arrives at it.
    fn fill_table(&mut self) {
        let count = self.patches.len();
        self.table.resize(count + 1, Vec4::ZERO);
        let (patches, arriving, bounced) = (&self.patches, &self.arriving, &self.bounced);
        self.table[1..].par_iter_mut().with_min_len(512).enumerate().for_each(|(i, out)| {
            let irradiance = arriving[i] + bounced[i];
            *out = (patches.albedo[i] / PI * irradiance + patches.emission[i]).extend(0.0);
        });
    }

    /// One bounce between all patches. Returns which part of them changed by more than [`ENOUGH`], and
    /// by more than [`SETTLED`].
    fn bounce(&mut self) -> (f32, f32) {
        let fronts = self.patches.fronts;
        let blocks: Vec<&Block> =
            self.blocks.iter().take(LOW_BLOCKS).filter(|b| b.origins() >= fronts).collect();
        let (table, valid) = (&self.table, &self.valid);
        let dark = self.brightest * DARK;
        let (much, little, largest) = self
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
                let level = new.max_element().max(dark).max(f32::MIN_POSITIVE);
                let change = (new - *bounced).abs().max_element() / level;
                *bounced = new;
                // Buried texels are filled below: what rays say of them is never the last word.
                let buried = valid.get(i).is_some_and(|valid| !valid);
                let over = |limit| u32::from(!buried && change > limit);
                (over(ENOUGH), over(SETTLED), new.max_element())
            })
            .reduce(|| (0, 0, 0.0_f32), |a, b| (a.0 + b.0, a.1 + b.1, a.2.max(b.2)));
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
        self.brightest = largest;
        let all = self.bounced.len().max(1) as f32;
        (much as f32 / all, little as f32 / all)
    }

    /// The last gather for a slice of the texels that are shown. Returns its end.
    fn gather(&mut self, start: usize) -> usize {
        let fronts = self.patches.fronts;
        let blocks: Vec<&Block> = self.blocks.iter().filter(|b| b.origins() >= fronts).collect();
        let Some((last, before)) = blocks.split_last() else { return fronts };
        let rays_before: u32 = before.iter().map(|b| b.count).sum();
        let rays = rays_before + last.count;
        let end = fronts.min(start + (GATHER_SLICE / rays as usize).max(1));
        let table = &self.table;
        let (sky, sky_halves): (&[Vec3], &[Vec3]) = match self.direct_sky {
            DirectSky::Included => (&self.sky, &self.sky_halves),
            DirectSky::LeftOut => (&[], &[]),
        };
        let of = |values: &[Vec3], i: usize| values.get(i).copied().unwrap_or(Vec3::ZERO);
        self.gathered[start..end]
            .par_iter_mut()
            .zip(&mut self.spread[start..end])
            .with_min_len(32)
            .enumerate()
            .for_each(|(i, (gathered, spread))| {
                let i = start + i;
                let old: Vec4 = before.iter().map(|b| b.gather(i, table)).sum();
                let new = last.gather(i, table);
                *gathered = (old + new).truncate() * (PI / rays as f32) + of(sky, i);
                let halves = new / last.count as f32 - old / rays_before.max(1) as f32;
                let halves = halves.truncate() + of(sky_halves, i);
                *spread = luminance(halves).abs() * PI * 0.5;
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
        self.sky_halves.clear();
        if self.sky_table.is_black() {
            return;
        }
        let table = &self.sky_table;
        let fronts = self.patches.fronts;
        let blocks: Vec<&Block> = self.blocks.iter().filter(|b| b.origins() >= fronts).collect();
        let mut rays = vec![0_u32; count];
        for (k, block) in blocks.iter().enumerate() {
            if k + 1 == blocks.len() {
                let mean = |(sum, rays): (&Vec3, &u32)| *sum / (*rays).max(1) as f32;
                self.sky_halves = self.sky.iter().zip(&rays).take(fronts).map(mean).collect();
            }
            let mut sums = vec![Vec3::ZERO; block.origins()];
            let of_origin = |rays: &[(u32, u32)]| {
                (rays[0].0, rays.iter().map(|(_, packed)| table.radiance(*packed)).sum())
            };
            let seen: Vec<(u32, Vec3)> =
                block.sky.par_chunk_by(|a, b| a.0 == b.0).map(of_origin).collect();
            for (origin, sum) in seen {
                sums[origin as usize] = sum;
            }
            if k + 1 == blocks.len() {
                for (half, sum) in self.sky_halves.iter_mut().zip(&sums) {
                    *half = *sum / block.count as f32 - *half;
                }
            }
            for (i, sum) in sums.into_iter().enumerate() {
                self.sky[i] += sum;
                rays[i] += block.count;
            }
        }
        for (sky, rays) in self.sky.iter_mut().zip(rays) {
            *sky *= PI / rays.max(1) as f32;
        }
    }
}
