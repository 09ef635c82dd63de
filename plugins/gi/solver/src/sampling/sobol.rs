//! Owen-scrambled Sobol points in four dimensions.
//!
//! Direction numbers of Joe and Kuo 2008 (first four dimensions); scrambling by a hash that only
//! lets higher digits change lower ones, after Laine and Karras 2011 and Burley 2020 ("Practical
//! Hash-based Owen Scrambling"), with the constants that N. Vegdahl found to scramble better.

use super::rng::{hash, to_unit};

/// One entry a bit of the index: the direction numbers of the four dimensions, digits reversed
/// (lowest bit = first binary digit), which is what the scrambling hash wants.
static DIRECTIONS: [[u32; 4]; 32] = directions();

const fn directions() -> [[u32; 4]; 32] {
    // Degree and inner coefficients of the primitive polynomial, and the first m values.
    const DIMENSIONS: [(usize, u32, [u32; 3]); 3] =
        [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];
    let mut table = [[0; 4]; 32];
    let mut bit = 0;
    while bit < 32 {
        table[bit][0] = 1 << bit;
        bit += 1;
    }
    let mut dimension = 0;
    while dimension < 3 {
        let (degree, coefficients, m) = DIMENSIONS[dimension];
        let mut v = [0_u32; 32];
        let mut i = 0;
        while i < 32 {
            v[i] = if i < degree {
                m[i] << (31 - i)
            } else {
                let mut x = v[i - degree] ^ (v[i - degree] >> degree);
                let mut k = 1;
                while k < degree {
                    if (coefficients >> (degree - 1 - k)) & 1 == 1 {
                        x ^= v[i - k];
                    }
                    k += 1;
                }
                x
            };
            table[i][dimension + 1] = v[i].reverse_bits();
            i += 1;
        }
        dimension += 1;
    }
    table
}

/// Scrambles digits given in reversed order: each bit is flipped depending on lower bits only.
const fn scramble_reversed(x: u32, seed: u32) -> u32 {
    let mut x = x ^ x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Owen scrambling in base 2: each bit is flipped depending on the bits above it and the seed.
/// A permutation of the 32-bit numbers that keeps elementary intervals together.
#[must_use]
pub const fn owen_scramble(x: u32, seed: u32) -> u32 {
    scramble_reversed(x.reverse_bits(), seed).reverse_bits()
}

fn sobol_reversed(index: u32) -> [u32; 4] {
    let mut x = [0; 4];
    let mut rest = index;
    while rest != 0 {
        let row = &DIRECTIONS[rest.trailing_zeros() as usize];
        for (x, d) in x.iter_mut().zip(row) {
            *x ^= d;
        }
        rest &= rest - 1;
    }
    x
}

/// Point `index` of the four-dimensional Sobol sequence as 32-bit fractions.
#[must_use]
pub fn sobol_4d(index: u32) -> [u32; 4] {
    sobol_reversed(index).map(u32::reverse_bits)
}

/// Point `index` of the sequence, each dimension scrambled on its own, in 0..1. Every aligned block
/// of 2ᵏ indices is a stratified point set; different seeds give independent ones.
#[must_use]
pub fn sobol_owen_4d(index: u32, seed: u64) -> [f32; 4] {
    let (a, b) = (hash(seed), hash(seed ^ 0x5851_f42d_4c95_7f2d));
    let seeds = [a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32];
    let digits = sobol_reversed(index);
    std::array::from_fn(|d| to_unit(scramble_reversed(digits[d], seeds[d]).reverse_bits()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first points in binary order; point 2ᵏ⁻¹ is m_k / 2ᵏ, worked out by hand from the recurrence.
    #[test]
    fn first_points() {
        let point = |i| sobol_4d(i).map(|x| f64::from(x) / 4_294_967_296.0);
        assert_eq!(point(0), [0.0; 4]);
        assert_eq!(point(1), [0.5; 4]);
        assert_eq!(point(2), [0.25, 0.75, 0.75, 0.75]);
        assert_eq!(point(3), [0.75, 0.25, 0.25, 0.25]);
        assert_eq!(point(4), [0.125, 0.625, 0.375, 0.125]);
    }

    /// The first two dimensions form a (0,2)-sequence: each elementary interval holds one point.
    /// Scrambling keeps that.
    #[test]
    fn scrambled_points_are_stratified() {
        for seed in 0..20_u64 {
            for block in 0..3_u32 {
                let points: Vec<_> =
                    (block * 256..(block + 1) * 256).map(|i| sobol_owen_4d(i, seed)).collect();
                for columns_log2 in 0..=8_u32 {
                    let (columns, rows) = (1 << columns_log2, 256 >> columns_log2);
                    let mut seen = vec![0; 256];
                    for p in &points {
                        let x = (p[0] * columns as f32) as usize;
                        let y = (p[1] * rows as f32) as usize;
                        seen[y * columns + x] += 1;
                    }
                    assert!(seen.iter().all(|n| *n == 1), "seed {seed}, {columns} columns");
                }
                // Each of the other dimensions alone is stratified.
                for d in 2..4 {
                    let mut seen = vec![0; 256];
                    points.iter().for_each(|p| seen[(p[d] * 256.0) as usize] += 1);
                    assert!(seen.iter().all(|n| *n == 1), "seed {seed}, dimension {d}");
                }
            }
        }
    }

    /// Over seeds, the mean of a smooth function is right: scrambling makes points uniform.
    #[test]
    fn scrambling_is_unbiased_over_seeds() {
        let replicates = 4000_u64;
        for index in [0_u32, 1, 5, 1000] {
            let (mut sum, mut squares) = ([0.0_f64; 4], [0.0_f64; 4]);
            for seed in 0..replicates {
                for (d, x) in sobol_owen_4d(index, hash(seed)).into_iter().enumerate() {
                    sum[d] += f64::from(x);
                    squares[d] += f64::from(x) * f64::from(x);
                }
            }
            let n = replicates as f64;
            for d in 0..4 {
                let z = (sum[d] / n - 0.5) / f64::sqrt(1.0 / 12.0 / n);
                let z2 = (squares[d] / n - 1.0 / 3.0) / f64::sqrt(4.0 / 45.0 / n);
                assert!(z.abs() < 4.5 && z2.abs() < 4.5, "index {index}, dimension {d}: {z} {z2}");
            }
        }
    }
}
