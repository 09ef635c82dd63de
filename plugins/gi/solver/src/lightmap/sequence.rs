//! Sample points whose every power-of-two prefix is well spread, and packed directions.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

/// Mixes a number into one that looks random (the finalizer of MurmurHash3).
pub(crate) fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x85eb_ca6b);
    x ^= x >> 13;
    x = x.wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

/// Mixes two numbers.
pub(crate) fn hash2(a: u32, b: u32) -> u32 {
    hash(a ^ hash(b.wrapping_add(0x9e37_79b9)))
}

/// Owen scrambling of a reversed number (Laine and Karras 2011, "Stratified sampling for stochastic
/// transparency", with the constants of Vegdahl 2021).
fn scramble(mut x: u32, seed: u32) -> u32 {
    x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// Point `index` of a scrambled (0, 2)-sequence in the unit square: the first two dimensions of
/// Sobol's sequence, each prefix of 2^k points a (0, k, 2)-net, another one for every seed.
pub(crate) fn sobol(index: u32, seed: u32) -> Vec2 {
    let mut second = 0;
    let (mut bits, mut column) = (index, 1u32 << 31);
    while bits != 0 {
        if bits & 1 != 0 {
            second ^= column;
        }
        bits >>= 1;
        column ^= column >> 1;
    }
    let unit = |x: u32| (x >> 8) as f32 * (1.0 / 16_777_216.0);
    Vec2::new(
        unit(scramble(index.reverse_bits(), hash(seed))),
        unit(scramble(second, hash(seed ^ 0x5bd1_e995))),
    )
}

/// A direction around `normal` with density cos / pi (Shirley and Chiu's concentric map).
pub(crate) fn cosine_direction(point: Vec2, normal: Vec3) -> Vec3 {
    let p = point * 2.0 - 1.0;
    let disk = if p == Vec2::ZERO {
        Vec2::ZERO
    } else if p.x.abs() > p.y.abs() {
        Vec2::from_angle(PI / 4.0 * (p.y / p.x)) * p.x
    } else {
        Vec2::from_angle(PI / 2.0 - PI / 4.0 * (p.x / p.y)) * p.y
    };
    let z = (1.0 - disk.length_squared()).max(0.0).sqrt();
    let (x_axis, y_axis) = normal.any_orthonormal_pair();
    (x_axis * disk.x + y_axis * disk.y + normal * z).normalize()
}

/// A direction with equal density everywhere.
pub(crate) fn sphere_direction(point: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * point.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * point.y).sin_cos();
    Vec3::new(r * cos, r * sin, z)
}

/// Packs a unit vector into 32 bits: octahedral map (Cigolle et al. 2014), 16 bits an axis.
pub(crate) fn pack_direction(d: Vec3) -> u32 {
    let d = d / (d.x.abs() + d.y.abs() + d.z.abs());
    let p = if d.z >= 0.0 {
        Vec2::new(d.x, d.y)
    } else {
        let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
        Vec2::new((1.0 - d.y.abs()) * sign(d.x), (1.0 - d.x.abs()) * sign(d.y))
    };
    let quantize = |v: f32| ((v * 0.5 + 0.5) * 65535.0).round().clamp(0.0, 65535.0) as u32;
    quantize(p.x) | (quantize(p.y) << 16)
}

/// Undoes [`pack_direction`].
pub(crate) fn unpack_direction(packed: u32) -> Vec3 {
    let axis = |v: u32| v as f32 / 65535.0 * 2.0 - 1.0;
    let p = Vec2::new(axis(packed & 0xffff), axis(packed >> 16));
    let z = 1.0 - p.x.abs() - p.y.abs();
    let fold = (-z).max(0.0);
    Vec3::new(p.x - fold.copysign(p.x), p.y - fold.copysign(p.y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_power_of_two_prefix_is_stratified() {
        for seed in 0..8 {
            for k in [4u32, 6, 8] {
                let n = 1u32 << k;
                // A (0, k, 2)-net: one point in each elementary interval of every shape.
                for split in 0..=k {
                    let (nx, ny) = (1u32 << split, 1u32 << (k - split));
                    let mut seen = vec![0; n as usize];
                    for i in 0..n {
                        let p = sobol(i, seed);
                        let (x, y) = ((p.x * nx as f32) as u32, (p.y * ny as f32) as u32);
                        seen[(y * nx + x) as usize] += 1;
                    }
                    assert!(seen.iter().all(|&count| count == 1), "seed {seed}, {nx}x{ny}");
                }
            }
        }
    }

    #[test]
    fn directions_have_the_right_means() {
        let n = 4096;
        let normal = Vec3::new(1.0, 2.0, -3.0).normalize();
        let mean =
            |f: &dyn Fn(Vec2) -> Vec3| (0..n).map(|i| f(sobol(i, 3))).sum::<Vec3>() / n as f32;
        // The mean of a cosine-distributed direction is 2/3 of the normal.
        let cosine = mean(&|p| cosine_direction(p, normal));
        assert!((cosine - normal * (2.0 / 3.0)).length() < 2e-3, "{cosine}");
        assert!(mean(&sphere_direction).length() < 2e-3);
    }

    #[test]
    fn packed_directions_come_back() {
        for i in 0..2000 {
            let d = sphere_direction(sobol(i, 9));
            let error = (unpack_direction(pack_direction(d)) - d).length();
            assert!(error < 1e-4, "{d} {error}");
        }
    }
}
