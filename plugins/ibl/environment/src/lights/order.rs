//! The order in which lights are used.
//!
//! Lights come in an order in which neighbours lie together on the sky. Equal steps through it, round
//! and round, spread every run of consecutive lights, of any length from any start, about evenly: a
//! lattice of rank 1. How evenly is told by the continued fraction of step / count, which should have
//! small terms only, as that of the golden section has (H. Niederreiter, *Random Number Generation and
//! Quasi-Monte Carlo Methods*, 1992, section 5.1). The start is random, so that each place of the
//! order holds each light with the same probability.

use crate::random::Random;

const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;

/// Reorders.
pub(super) fn spread<T: Clone>(sorted: &[T], random: &mut Random) -> Vec<T> {
    let count = sorted.len();
    let step = step(count);
    let start = (random.unit() * count as f64) as usize;
    (0..count).map(|at| sorted[(start + at * step) % count].clone()).collect()
}

/// The step that reaches each of `count` places and spreads best.
fn step(count: usize) -> usize {
    let best = (1..count).filter_map(|step| {
        let off = (step as f64 / count as f64 - GOLDEN_SECTION).abs();
        Some((greatest_term(step, count)?, off, step))
    });
    best.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))).map_or(1, |(.., step)| step)
}

/// The greatest term of the continued fraction of `a / b`; none if they share a divisor.
fn greatest_term(mut a: usize, mut b: usize) -> Option<usize> {
    let mut greatest = 0;
    while a > 0 {
        greatest = greatest.max(b / a);
        (a, b) = (b % a, a);
    }
    (b == 1).then_some(greatest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_is_spread() {
        for count in [1, 2, 3, 5, 64, 200, 255, 1000, 4096] {
            let sorted: Vec<usize> = (0..count).collect();
            let order = spread(&sorted, &mut Random::new(3));
            let mut again = order.clone();
            again.sort_unstable();
            assert_eq!(again, sorted);
            for run in [2, 5, 8, 21, 64] {
                if run * 2 > count {
                    continue;
                }
                for start in 0..count {
                    let mut places: Vec<_> =
                        (start..start + run).map(|at| order[at % count]).collect();
                    places.sort_unstable();
                    places.push(places[0] + count);
                    let gaps = places.windows(2).map(|pair| pair[1] - pair[0]);
                    // Evenly spread gaps would be count / run. With terms of at most 3, a multiple
                    // below `run` of the step is at least 1 / (5 run) of the count away from none.
                    let least = gaps.min().unwrap_or(0);
                    assert!(least * run * 5 >= count, "{count} {run} {start}: {least}");
                }
            }
        }
    }

    #[test]
    fn each_place_holds_each_light_as_often() {
        let sorted: Vec<usize> = (0..10).collect();
        let mut seen = [[0; 10]; 10];
        for seed in 0..5000 {
            for (place, light) in spread(&sorted, &mut Random::new(seed)).into_iter().enumerate() {
                seen[place][light] += 1;
            }
        }
        // 500 each; five times the standard deviation of a binomial distribution is 106.
        assert!(seen.iter().flatten().all(|count| (394..=606).contains(count)), "{seen:?}");
    }
}
