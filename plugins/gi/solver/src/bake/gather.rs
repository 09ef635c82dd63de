//! Passes of gather rays.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

use super::Layout;
use crate::{
    World,
    estimate::Progress,
    path::PathTracer,
    receiver::Receiver,
    sampling::{PathSampler, hash_pair},
    scene::DirectSky,
};

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
    /// Sums of irradiance over the first and the second half of every pass's rays.
    pub halves: [Vec<Vec3>; 2],
}

/// Gathers light for the texels of a layout.
pub struct Gatherer<'a> {
    tracer: PathTracer<'a>,
    layout: &'a Layout,
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
        progress(0).is_continue().then(|| Self { tracer: PathTracer::new(world), layout, settings })
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
        let patches = &self.layout.patches;
        let half = rays / 2;
        let sums: Vec<[Vec3; 2]> = (0..self.layout.len())
            .into_par_iter()
            .with_min_len(16)
            .map(|i| {
                let receiver =
                    Receiver { position: patches.position[i], normal: patches.normal[i] };
                let set = hash_pair(self.settings.seed, i as u64);
                let mut sums = [Vec3::ZERO; 2];
                for ray in 0..half * 2 {
                    let mut sampler = PathSampler::new(set, gathered.rays + ray, 16);
                    let light = receiver.sample(&self.tracer, &mut sampler);
                    let sky = match self.settings.direct_sky {
                        DirectSky::Included => light.sky,
                        DirectSky::LeftOut => Vec3::ZERO,
                    };
                    sums[(ray / half) as usize] += light.indirect + sky;
                }
                progress(u64::from(rays)).is_continue().then_some(sums)
            })
            .collect::<Option<_>>()?;
        for (i, sums) in sums.into_iter().enumerate() {
            gathered.halves[0][i] += sums[0];
            gathered.halves[1][i] += sums[1];
        }
        gathered.rays += half * 2;
        Some(())
    }

    /// Median over lit texels of the relative standard error, from the two halves.
    #[must_use]
    pub fn relative_error(&self, gathered: &Gathered) -> f32 {
        /// Median of the magnitude of a normally distributed number.
        const MEDIAN: f32 = 0.674_5;
        let luminance = |c: Vec3| c.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        let of = |i: usize| luminance(gathered.irradiance(i)) / PI;
        let brightest = (0..self.layout.len()).map(of).fold(0.0, f32::max);
        let mut errors: Vec<f32> = (0..self.layout.len())
            .filter(|&i| self.layout.open[i] && of(i) > brightest * 0.001)
            .map(|i| luminance(gathered.difference(i)).abs() / PI / of(i))
            .collect();
        if errors.is_empty() {
            return 0.0;
        }
        let middle = errors.len() / 2;
        let (_, median, _) = errors.select_nth_unstable_by(middle, f32::total_cmp);
        *median / MEDIAN
    }
}
