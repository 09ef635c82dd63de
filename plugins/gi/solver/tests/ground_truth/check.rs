//! Comparisons in units of the standard error.

use farlight_gi_solver::estimate::{Estimate, GatherSettings};
use glam::Vec3;

/// Paths and a fixed seed.
pub(crate) fn paths(paths: u32) -> GatherSettings {
    GatherSettings { paths, seed: 2024 }
}

/// Panics unless an estimate agrees with the truth within 5 standard errors plus a relative
/// allowance for what the scene itself is wrong by (a polyhedron that stands for a sphere) and for
/// rounding. 5 because 32 replicates know the standard error to 13 % and there are hundreds of
/// comparisons: for Student's t with 31 degrees of freedom that happens by chance once in 50,000.
#[track_caller]
pub(crate) fn agrees(what: &str, estimate: Estimate, truth: Vec3, allowance: f32) {
    for c in 0..3 {
        let (mean, se, truth) = (estimate.mean[c], estimate.se[c], truth[c]);
        let tolerance = 5.0 * se + (allowance + 2e-5) * truth.abs() + 1e-7;
        assert!(
            (mean - truth).abs() <= tolerance,
            "{what}, channel {c}: {mean} +- {se}, but {truth} is right"
        );
        assert!(se.is_finite() && mean.is_finite(), "{what}, channel {c}: {mean} +- {se}");
    }
}

/// Panics if the relative standard error is above a bound: a test that agrees within noise proves
/// nothing if the noise is large.
#[track_caller]
pub(crate) fn sharp(what: &str, estimate: Estimate, relative: f32) {
    for c in 0..3 {
        assert!(
            estimate.se[c] <= relative * estimate.mean[c].abs(),
            "{what}, channel {c}: {} +- {}",
            estimate.mean[c],
            estimate.se[c]
        );
    }
}
