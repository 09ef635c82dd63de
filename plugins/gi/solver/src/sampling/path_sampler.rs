//! The numbers of one path.

use glam::Vec2;

use super::{
    rng::{Rng, hash_pair},
    sobol::{owen_scramble, sobol_owen_4d},
};

/// Points that come from low-discrepancy points; later ones are independent numbers.
const STRATIFIED_PAIRS: u32 = 16;

/// Gives one path its random numbers.
///
/// Path `index` of a set of `2^set_log2` paths takes its first direction and the second from one
/// point of an Owen-scrambled Sobol set, the third and fourth from another such set in shuffled
/// order, and so on ("padding", Kollig and Keller 2002); after sixteen points, and for decisions
/// such as Russian roulette, the numbers are independent.
///
/// Sets with different seeds are independent and each is unbiased, so the spread of the means of
/// several sets is an honest estimate of the error. Within one set the points are *not*
/// independent: the spread of single paths says nothing about the error of their mean.
#[derive(Clone, Debug)]
pub struct PathSampler {
    set: u64,
    index: u32,
    set_log2: u32,
    pair: u32,
    point: [f32; 4],
    rng: Rng,
}

impl PathSampler {
    /// Numbers of path `index` of the set named by `set` (a hash of seed, receiver and replicate).
    /// Paths of one set are stratified against each other in aligned blocks of `2^set_log2`
    /// indices; `set_log2` is at most 32.
    #[must_use]
    pub fn new(set: u64, index: u32, set_log2: u32) -> Self {
        Self {
            set,
            index,
            set_log2: set_log2.min(32),
            pair: 0,
            point: [0.0; 4],
            rng: Rng::new(set, u64::from(index)),
        }
    }

    /// The next point of the unit square: for directions, in the order of the path's vertices.
    pub fn next_2d(&mut self) -> Vec2 {
        if self.pair >= STRATIFIED_PAIRS {
            return self.rng.next_2d().into();
        }
        if self.pair.is_multiple_of(2) {
            let seed = hash_pair(self.set, u64::from(self.pair) + 1);
            self.point = sobol_owen_4d(self.shuffled(seed as u32), seed);
        }
        let second = (self.pair % 2 * 2) as usize;
        self.pair += 1;
        Vec2::new(self.point[second], self.point[second + 1])
    }

    /// An independent number 0 ≤ x < 1, for decisions.
    pub fn next_1d(&mut self) -> f32 {
        self.rng.next_f32()
    }

    /// The index within its block, shuffled so that the block's points stay the same set; the first
    /// set keeps its order.
    fn shuffled(&self, seed: u32) -> u32 {
        if self.pair == 0 || self.set_log2 == 0 {
            return self.index;
        }
        let shift = 32 - self.set_log2;
        let low = owen_scramble(self.index << shift, seed) >> shift;
        if shift == 0 { low } else { (self.index >> self.set_log2) << self.set_log2 | low }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each direction of a set is stratified, in each aligned block, and sets differ.
    #[test]
    fn every_direction_of_a_set_is_stratified() {
        for pair in 0..STRATIFIED_PAIRS {
            for block in 0..2_u32 {
                let mut seen = vec![0; 64];
                for i in block * 64..(block + 1) * 64 {
                    let mut sampler = PathSampler::new(9, i, 6);
                    let mut u = sampler.next_2d();
                    (0..pair).for_each(|_| u = sampler.next_2d());
                    // Alternate pairs are dimensions 0, 1 and 2, 3: the first coordinate of either
                    // is stratified into as many intervals as there are points.
                    seen[(u.x * 64.0) as usize] += 1;
                }
                assert!(seen.iter().all(|n| *n == 1), "direction {pair}, block {block}");
            }
        }
        assert_ne!(PathSampler::new(9, 0, 6).next_2d(), PathSampler::new(10, 0, 6).next_2d());
    }

    /// Numbers beyond the stratified ones go on and stay in range.
    #[test]
    fn long_paths_have_numbers() {
        let mut sampler = PathSampler::new(1, 0, 4);
        let draws: Vec<_> = (0..100).map(|_| sampler.next_2d()).collect();
        assert!(draws.iter().all(|u| (0.0..1.0).contains(&u.x) && (0.0..1.0).contains(&u.y)));
        assert_ne!(draws[98], draws[99]);
    }
}
