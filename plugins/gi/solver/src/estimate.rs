//! Means of many paths with honest standard errors.
//!
//! Paths of one low-discrepancy set are not independent, so their spread says nothing about the
//! error of their mean. Several independent sets (replicates) are: the spread of *their* means
//! does. 32 replicates know the standard error to about 13 %, and a z value formed with it follows
//! Student's t with 31 degrees of freedom (RMS 1.03).

use std::ops::ControlFlow;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::sampling::{PathSampler, hash_pair};

/// Most independent sets an estimate is made of.
pub const REPLICATES: u32 = 32;

/// A mean and the standard error of that mean (one sigma), per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: Vec3,
    /// Its standard error.
    pub se: Vec3,
}

/// How much to trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GatherSettings {
    /// Paths a receiver or probe, rounded up to a multiple of the number of replicates (32, fewer
    /// below 256 paths, never below 2). Powers of two are stratified best.
    pub paths: u32,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Default for GatherSettings {
    fn default() -> Self {
        Self { paths: 4096, seed: 1 }
    }
}

impl GatherSettings {
    /// Replicates, and paths in each.
    #[must_use]
    pub fn split(&self) -> (u32, u32) {
        let replicates = (self.paths / 8).clamp(2, REPLICATES);
        (replicates, self.paths.div_ceil(replicates).max(1))
    }

    /// Paths that are really traced for each receiver.
    #[must_use]
    pub fn traced(&self) -> u64 {
        let (replicates, each) = self.split();
        u64::from(replicates) * u64::from(each)
    }
}

/// Called with the number of paths done since the last call, from any thread; may stop the work.
pub type Progress<'a> = &'a (dyn Fn(u64) -> ControlFlow<()> + Sync);

/// A [`Progress`] that reports nothing and never stops.
pub fn no_progress() -> Progress<'static> {
    &|_| ControlFlow::Continue(())
}

/// Estimates `N` means over paths. `stream` tells receivers apart; `path` adds what one path gives
/// to the sums.
pub(crate) fn estimate<const N: usize>(
    settings: &GatherSettings,
    stream: u64,
    progress: Progress<'_>,
    path: impl Fn(&mut PathSampler, &mut [DVec3; N]) + Sync,
) -> Option<[Estimate; N]> {
    let (replicates, each) = settings.split();
    let set_log2 = 32 - (each - 1).leading_zeros();
    let stream = hash_pair(settings.seed, stream);
    let means: Vec<[DVec3; N]> = (0..replicates)
        .into_par_iter()
        .map(|replicate| {
            let set = hash_pair(stream, u64::from(replicate));
            let mut sums = [DVec3::ZERO; N];
            for index in 0..each {
                path(&mut PathSampler::new(set, index, set_log2), &mut sums);
            }
            progress(u64::from(each)).is_continue().then(|| sums.map(|s| s / f64::from(each)))
        })
        .collect::<Option<_>>()?;
    let n = f64::from(replicates);
    Some(std::array::from_fn(|i| {
        let mean = means.iter().map(|m| m[i]).sum::<DVec3>() / n;
        let squares: DVec3 = means.iter().map(|m| (m[i] - mean) * (m[i] - mean)).sum();
        let variance = squares / (n * (n - 1.0));
        let se = DVec3::new(variance.x.sqrt(), variance.y.sqrt(), variance.z.sqrt());
        Estimate { mean: mean.as_vec3(), se: se.as_vec3() }
    }))
}
