//! Ending paths at random.

use glam::Vec3;

/// When paths are ended at random.
///
/// A path survives with probability min(1, throughput / `threshold`), throughput being its largest
/// channel, and from `forced_after` reflections on with 0.95 at most, so that it ends even between
/// perfect reflectors. Survivors are weighted up by the inverse, which keeps the mean.
#[derive(Clone, Copy, Debug)]
pub(super) struct Roulette {
    pub(super) threshold: f32,
    pub(super) forced_after: u32,
}

impl Roulette {
    /// Ends what carries less than a tenth. Earlier ends make paths cheaper and noisier: in two
    /// rooms joined by a doorway a threshold of 1 has 2.5 times the variance at 0.45 times the time,
    /// one of 0.01 the same variance at 1.6 times the time.
    pub(super) const STANDARD: Self = Self { threshold: 0.1, forced_after: 24 };

    /// Probability that a path goes on.
    pub(super) fn survival(self, throughput: Vec3, reflections: u32) -> f32 {
        let most = if reflections > self.forced_after { 0.95 } else { 1.0 };
        (throughput.max_element() / self.threshold).min(most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Paths between perfect reflectors end.
    #[test]
    fn paths_end() {
        assert!(Roulette::STANDARD.survival(Vec3::splat(1e9), 25) <= 0.95);
        assert_eq!(Roulette::STANDARD.survival(Vec3::ONE, 1), 1.0);
        assert!((Roulette::STANDARD.survival(Vec3::splat(0.05), 1) - 0.5).abs() < 1e-6);
    }
}
