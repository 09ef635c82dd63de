//! Passes of gather rays.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use super::{
    DirectLight, Layout, cells::Cells, direct::direct_by, field::Field, links, lobe::Bent,
    map::TexelMap, sources::Sources, uneven::uneven,
};
use crate::{
    World,
    estimate::Progress,
    lightmap::{luminance, median},
    path::PathTracer,
    sampling::{PathSampler, hash_pair},
    scene::DirectSky,
    visibility::offset_origin,
};

/// Texels darker than this part of the brightest don't count where errors are relative.
const DARK: f32 = 1e-3;

/// How to gather.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GathererSettings {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Most reflections of light; 0 is no limit.
    pub bounces: u32,
    /// Whether what arrives straight from the sky is part of it.
    pub direct_sky: DirectSky,
}

/// What was gathered so far for the texels of a layout.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gathered {
    /// Rays a texel; even.
    pub rays: u32,
    /// Sums of irradiance, each over half of the rays. The halves are independent of each other: their
    /// difference tells the noise.
    pub halves: [Vec<Vec3>; 2],
}

/// Gathers light for the texels of a layout.
pub struct Gatherer<'a> {
    pub(super) field: Field<'a>,
    settings: GathererSettings,
}

impl Gathered {
    /// Nothing yet.
    #[must_use]
    pub fn new(layout: &Layout) -> Self {
        Self { rays: 0, halves: [0, 1].map(|_| vec![Vec3::ZERO; layout.len()]) }
    }

    /// Irradiance of a texel.
    #[must_use]
    pub fn irradiance(&self, texel: usize) -> Vec3 {
        (self.halves[0][texel] + self.halves[1][texel]) / self.rays.max(1) as f32
    }

    /// Half the difference of the two halves: one sample of the irradiance's standard error.
    #[must_use]
    pub fn difference(&self, texel: usize) -> Vec3 {
        (self.halves[0][texel] - self.halves[1][texel]) / self.rays.max(1) as f32
    }

    /// Median over lit texels of the relative standard error of what was gathered, as far as the two halves
    /// disagree: squares of their differences, the mean over each texel and its neighbours.
    #[must_use]
    pub fn relative_error(&self, layout: &Layout) -> f32 {
        let of = |i: usize| luminance(self.irradiance(i));
        let brightest = (0..layout.len()).map(of).fold(0.0, f32::max);
        let lit = |i: usize| layout.open[i] && of(i) > brightest * DARK;
        let mut errors: Vec<f32> = Vec::new();
        for receiver in &layout.patches.receivers {
            let (first, texels) = (receiver.first as usize, &receiver.texels);
            for i in (0..texels.len()).filter(|i| lit(first + i)) {
                let [x, y] = texels.coords[i].map(i64::from);
                let (mut squares, mut sum, mut n) = (0.0, 0.0, 0.0);
                for k in 0..9 {
                    let other = texels.at(x + k % 3 - 1, y + k / 3 - 1, texels.chart[i]);
                    let Some(other) = other.map(|o| first + o as usize).filter(|o| lit(*o)) else {
                        continue;
                    };
                    squares += luminance(self.difference(other)).powi(2);
                    sum += of(other);
                    n += 1.0;
                }
                errors.push((squares / n).sqrt() * n / sum);
            }
        }
        median(&mut errors).unwrap_or(0.0)
    }
}

impl<'a> Gatherer<'a> {
    /// Prepares for a world with its lights and sky. `None` if `progress` stopped the work.
    #[must_use]
    pub fn new(
        world: &'a World,
        layout: &'a Layout,
        settings: GathererSettings,
        progress: Progress<'_>,
    ) -> Option<Self> {
        let lights: Vec<_> =
            world.lights.iter().map(|&light| DirectLight { light, radius: 0.0 }).collect();
        let map = TexelMap::new(world, layout);
        let direct = direct_by(&map, world, layout, &lights, &|_| progress(0))?;
        let (rays, edge) = links::resolution(layout.len());
        let mut field = Field {
            tracer: PathTracer::new(world),
            layout,
            map,
            cells: Cells::new(world, layout, edge),
            bounces: if settings.bounces == 0 { u32::MAX } else { settings.bounces },
            direct,
            uneven: uneven(world, layout),
            levels: Vec::new(),
            leaving: Vec::new(),
            sources: Sources::default(),
        };
        field.solve(rays, settings.seed, progress)?;
        Some(Self { field, settings })
    }

    /// What it gathers.
    #[must_use]
    pub fn settings(&self) -> &GathererSettings {
        &self.settings
    }

    /// Adds `rays` rays (even) to every texel: indirect light, and the sky's direct light unless the
    /// settings leave it out. `None`, and nothing added, if `progress` stopped the work.
    #[must_use]
    pub fn pass(&self, gathered: &mut Gathered, rays: u32, progress: Progress<'_>) -> Option<()> {
        let half = rays / 2;
        let done = gathered.rays / 2;
        let layout = self.field.layout;
        let sums: Vec<[Vec3; 2]> = (0..layout.len())
            .into_par_iter()
            .with_min_len(16)
            .map(|i| {
                let mut sums = [gathered.halves[0][i], gathered.halves[1][i]];
                self.add(i, done..done + half, &mut sums);
                progress(u64::from(rays)).is_continue().then_some(sums)
            })
            .collect::<Option<_>>()?;
        for (i, sums) in sums.into_iter().enumerate() {
            gathered.halves[0][i] = sums[0];
            gathered.halves[1][i] = sums[1];
        }
        gathered.rays += half * 2;
        Some(())
    }

    /// Irradiance of one texel by the first `rays` rays (even), for measuring: what a [`pass`](Self::pass)
    /// gives it.
    #[must_use]
    pub fn irradiance(&self, texel: usize, rays: u32) -> Vec3 {
        let mut sums = [Vec3::ZERO; 2];
        self.add(texel, 0..rays / 2, &mut sums);
        (sums[0] + sums[1]) / rays.max(1) as f32
    }

    /// Adds rays to both sums of a texel.
    fn add(&self, texel: usize, rays: Range<u32>, sums: &mut [Vec3; 2]) {
        let layout = self.field.layout;
        if !layout.open[texel] {
            return;
        }
        let geometric = layout.patches.normal[texel];
        let origin = offset_origin(layout.patches.position[texel], geometric);
        let lobe = Bent::new(layout.shading[texel], geometric);
        let sky = self.settings.direct_sky == DirectSky::Included;
        for (k, sum) in sums.iter_mut().enumerate() {
            // The halves are sequences of their own, so that they are independent.
            let set = hash_pair(self.settings.seed, (texel * 2 + k) as u64);
            for ray in rays.clone() {
                let mut sampler = PathSampler::new(set, ray, 16);
                self.field.sample(origin, &lobe, sky, &mut sampler, |direction, light| {
                    *sum += light * lobe.weight(direction);
                });
            }
        }
    }
}
