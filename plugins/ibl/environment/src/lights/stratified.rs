//! Low-discrepancy points.

use super::{EnvironmentLight, density::Density};
use crate::random::Random;

/// N lights, each radiance / (N pdf), at the points of a scrambled Sobol sequence. Any run of 2^k
/// lights that starts at a multiple of 2^k is spread by itself.
pub(super) fn lights(
    density: &Density,
    count: usize,
    random: &mut Random,
) -> Vec<EnvironmentLight> {
    let seeds = [random.next() as u32, random.next() as u32];
    (0..count as u32)
        .map(|at| {
            let point = density.sample(sobol(at, seeds));
            let irradiance = density.weight(point.texel) / count as f64;
            EnvironmentLight {
                direction: point.direction.as_vec3(),
                irradiance: irradiance.as_vec3(),
            }
        })
        .collect()
}

/// Point `at` of the Sobol sequence in the unit square, each dimension scrambled as A. B. Owen does
/// it, so that each point alone is even over the square.
fn sobol(at: u32, seeds: [u32; 2]) -> [f64; 2] {
    let (mut second, mut direction, mut bits) = (0_u32, 1_u32 << 31, at);
    while bits != 0 {
        if bits & 1 != 0 {
            second ^= direction;
        }
        // The polynomial x + 1: the matrix of Pascal's triangle.
        direction ^= direction >> 1;
        bits >>= 1;
    }
    let unit = |reversed: u32, seed: u32| {
        (f64::from(scramble(reversed, seed).reverse_bits()) + 0.5) / 2.0_f64.powi(32)
    };
    // The first dimension is the number with its bits reversed.
    [unit(at, seeds[0]), unit(second.reverse_bits(), seeds[1])]
}

/// Owen's scrambling of bit-reversed numbers by a hash (B. Burley, *Practical Hash-based Owen
/// Scrambling*, Journal of Computer Graphics Techniques 9(4), 2020; the constants are those of N. Vegdahl,
/// <https://psychopath.io/post/2021_01_30_building_a_better_lk_hash>).
fn scramble(mut x: u32, seed: u32) -> u32 {
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_spread_in_every_elementary_rectangle() {
        for seeds in [[1, 2], [77, 0x9e37_79b9]] {
            for (columns, rows) in [(64, 1), (16, 4), (8, 8), (2, 32), (1, 64)] {
                // Any aligned run of 64 has one point in each.
                for start in [0, 64, 640] {
                    let mut seen = [0; 64];
                    for at in start..start + 64 {
                        let [x, y] = sobol(at, seeds);
                        let [x, y] = [x * f64::from(columns), y * f64::from(rows)];
                        seen[y as usize * columns as usize + x as usize] += 1;
                    }
                    assert_eq!(seen, [1; 64], "{columns} x {rows} from {start}");
                }
            }
        }
    }

    #[test]
    fn one_point_is_even_over_seeds() {
        let mut random = Random::new(5);
        let mut seen = [0; 16];
        for _ in 0..16_000 {
            let [x, y] = sobol(3, [random.next() as u32, random.next() as u32]);
            seen[(4.0 * y) as usize * 4 + (4.0 * x) as usize] += 1;
        }
        // 1000 each; five times the standard deviation is 153.
        assert!(seen.iter().all(|count| (847..=1153).contains(count)), "{seen:?}");
    }
}
