//! Drawing from a list of weights.

use glam::Vec2;

use crate::sampling::PathSampler;

/// Entries drawn in proportion to their weights.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    /// Sum of the weights up to and including each entry.
    sums: Vec<f64>,
}

impl Table {
    /// A table of weights; those that are not above 0 and finite are never drawn.
    pub(crate) fn new(weights: impl Iterator<Item = f32>) -> Self {
        let mut sum = 0.0;
        let usable = |w: f32| if w > 0.0 && w.is_finite() { f64::from(w) } else { 0.0 };
        Self {
            sums: weights
                .map(|w| {
                    sum += usable(w);
                    sum
                })
                .collect(),
        }
    }

    /// Sum of all weights.
    pub(crate) fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// Whether nothing can be drawn.
    pub(crate) fn is_empty(&self) -> bool {
        self.total() <= 0.0
    }

    /// The entry for a number 0 ≤ u < 1, and where in the entry the number lies, 0..=1: uniform again,
    /// so that one stratified number draws both an entry and a place in it. The table must not be
    /// empty.
    pub(crate) fn draw(&self, u: f64) -> (usize, f32) {
        let target = u * self.total();
        // The first sum above the target: entries without weight have the sum of the one before and
        // are passed over.
        let entry = self.sums.partition_point(|sum| *sum <= target).min(self.sums.len() - 1);
        let start = if entry == 0 { 0.0 } else { self.sums[entry - 1] };
        let within = (target - start) / (self.sums[entry] - start);
        (entry, within.clamp(0.0, 1.0) as f32)
    }

    /// Draws an entry, and a point of the unit square for a place in it.
    pub(crate) fn sample(&self, sampler: &mut PathSampler) -> (usize, Vec2) {
        let u = sampler.next_2d();
        // Digits below those of a 24-bit number, for entries with little weight.
        let fine = f64::from(u.x) + f64::from(sampler.next_1d()) / 16_777_216.0;
        let (entry, within) = self.draw(fine);
        (entry, Vec2::new(within, u.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_drawn_in_proportion() {
        let table = Table::new([0.0, 1.0, f32::NAN, 3.0, -2.0, 0.0].into_iter());
        assert_eq!(table.total(), 4.0);
        let mut counts = [0; 6];
        (0..400).for_each(|i| counts[table.draw(f64::from(i) / 400.0).0] += 1);
        assert_eq!(counts, [0, 100, 0, 300, 0, 0]);
        assert_eq!(table.draw(0.125), (1, 0.5));
        assert_eq!(table.draw(0.625), (3, 0.5));
        assert_eq!(table.draw(1.0 - 1e-12).0, 3);
        assert!(Table::new([0.0, f32::INFINITY].into_iter()).is_empty());
        assert!(Table::default().is_empty());
    }
}
