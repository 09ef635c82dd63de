//! Independent random numbers and hashes.

/// Mixes 64 bits so that each input bit changes each output bit with probability near one half
/// (the finalizer of SplitMix64, Steele, Lea and Flood 2014).
#[must_use]
pub const fn hash(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// One hash of two values; the order counts.
#[must_use]
pub const fn hash_pair(a: u64, b: u64) -> u64 {
    hash(hash(a) ^ b)
}

/// Maps 32 random bits to 0 ≤ x < 1, exact multiples of 2⁻²⁴.
#[must_use]
pub const fn to_unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A small, fast generator: PCG32 (O'Neill 2014, XSH-RR output), period 2⁶⁴ a stream.
#[derive(Clone, Debug)]
pub struct Rng {
    state: u64,
    increment: u64,
}

impl Rng {
    /// A generator for a seed and an index (of a pixel, a path, a texel). Different pairs give
    /// independent numbers.
    #[must_use]
    pub const fn new(seed: u64, index: u64) -> Self {
        let state = hash_pair(seed, index);
        Self { state, increment: hash(state) | 1 }
    }

    /// 32 random bits.
    pub const fn next_u32(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(self.increment);
        let xored = (((old >> 18) ^ old) >> 27) as u32;
        xored.rotate_right((old >> 59) as u32)
    }

    /// A number 0 ≤ x < 1.
    pub const fn next_f32(&mut self) -> f32 {
        to_unit(self.next_u32())
    }

    /// A point of the unit square.
    pub const fn next_2d(&mut self) -> [f32; 2] {
        [self.next_f32(), self.next_f32()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_repeat_under_a_seed_and_differ_between_indices() {
        let draw = |seed, index| {
            let mut rng = Rng::new(seed, index);
            [rng.next_u32(), rng.next_u32(), rng.next_u32()]
        };
        assert_eq!(draw(1, 2), draw(1, 2));
        assert_ne!(draw(1, 2), draw(2, 1));
        assert_ne!(draw(1, 2), draw(1, 3));
    }

    /// Mean and variance over streams (first numbers) and within one stream.
    #[test]
    fn numbers_are_uniform() {
        let n = 100_000_u32;
        let check = |values: &mut dyn Iterator<Item = f32>, what: &str| {
            let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
            for v in values {
                assert!((0.0..1.0).contains(&v));
                sum += f64::from(v);
                squares += f64::from(v) * f64::from(v);
            }
            let n = f64::from(n);
            // Var[x] = 1/12, Var[x²] = 4/45.
            let z_mean = (sum / n - 0.5) / (1.0 / 12.0 / n).sqrt();
            let z_square = (squares / n - 1.0 / 3.0) / (4.0 / 45.0 / n).sqrt();
            assert!(z_mean.abs() < 4.0 && z_square.abs() < 4.0, "{what}: {z_mean} {z_square}");
        };
        check(&mut (0..n).map(|i| Rng::new(7, u64::from(i)).next_f32()), "streams");
        let mut rng = Rng::new(7, 0);
        check(&mut (0..n).map(|_| rng.next_f32()), "one stream");
    }
}
