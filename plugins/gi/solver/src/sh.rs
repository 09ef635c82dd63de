//! Real spherical harmonics to order 2.

use std::{
    f32::consts::PI,
    ops::{Add, AddAssign, Mul},
};

use glam::Vec3;

/// Nine RGB coefficients of a real orthonormal basis without Condon-Shortley phase, order (0,0),
/// (1,-1), (1,0), (1,1), (2,-2) .. (2,2), z the polar axis of the formulas; of incident radiance
/// (not convolved with the cosine).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShRgb(pub [Vec3; 9]);

/// Y₀₀ = 1 / (2 √π).
const Y0: f32 = 0.282_094_8;
/// √(3 / 4π).
const Y1: f32 = 0.488_602_52;
/// √(15 / 4π).
const Y2: f32 = 1.092_548_5;
/// √(5 / 16π).
const Y2_ZONAL: f32 = 0.315_391_57;
/// √(15 / 16π).
const Y2_SECTORAL: f32 = 0.546_274_2;

/// The nine basis functions in a unit direction, in the order of [`ShRgb`]:
/// `Y0; Y1 y, Y1 z, Y1 x; Y2 xy, Y2 yz, Y2' (3z² - 1), Y2 xz, Y2'' (x² - y²)`.
#[must_use]
pub fn sh_basis(d: Vec3) -> [f32; 9] {
    [
        Y0,
        Y1 * d.y,
        Y1 * d.z,
        Y1 * d.x,
        Y2 * d.x * d.y,
        Y2 * d.y * d.z,
        Y2_ZONAL * (3.0 * d.z * d.z - 1.0),
        Y2 * d.x * d.z,
        Y2_SECTORAL * (d.x * d.x - d.y * d.y),
    ]
}

impl ShRgb {
    /// No light.
    pub const ZERO: Self = Self([Vec3::ZERO; 9]);

    /// Adds `radiance` that arrives from the unit direction `direction` (pointing away from the
    /// probe), weighted by the solid angle it stands for: for n directions drawn uniformly over the
    /// sphere give `L · 4π / n`.
    pub fn add_direction(&mut self, direction: Vec3, radiance: Vec3) {
        for (c, y) in self.0.iter_mut().zip(sh_basis(direction)) {
            *c += radiance * y;
        }
    }

    /// Radiance that arrives from a unit direction, as far as order 2 holds it. May be negative.
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.0.iter().zip(sh_basis(direction)).map(|(c, y)| *c * y).sum()
    }

    /// Irradiance on a plane with the unit normal `normal`: each band is multiplied by what the
    /// clamped cosine does to it, π, 2π/3, π/4 (Ramamoorthi and Hanrahan 2001). May be slightly
    /// negative where the light is much brighter on one side.
    #[must_use]
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        const BANDS: [f32; 9] = [
            PI,
            2.0 * PI / 3.0,
            2.0 * PI / 3.0,
            2.0 * PI / 3.0,
            PI / 4.0,
            PI / 4.0,
            PI / 4.0,
            PI / 4.0,
            PI / 4.0,
        ];
        let y = sh_basis(normal);
        (0..9).map(|i| self.0[i] * (y[i] * BANDS[i])).sum()
    }

    /// Bevy's ambient cube: E(axis) / π, clamped at 0, for the directions +x, -x, +y, -y, +z, -z:
    /// what an `IrradianceVolume` stores for surfaces that face that way.
    #[must_use]
    pub fn ambient_cube(&self) -> [Vec3; 6] {
        [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z]
            .map(|axis| (self.irradiance(axis) / PI).max(Vec3::ZERO))
    }

    /// Weighted sum of two: `self (1 - t) + other t`.
    #[must_use]
    pub fn lerp(&self, other: &Self, t: f32) -> Self {
        Self(std::array::from_fn(|i| self.0[i].lerp(other.0[i], t)))
    }
}

impl Add for ShRgb {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl AddAssign for ShRgb {
    fn add_assign(&mut self, other: Self) {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += b;
        }
    }
}

impl Mul<f32> for ShRgb {
    type Output = Self;
    fn mul(self, scale: f32) -> Self {
        Self(self.0.map(|c| c * scale))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Rng, uniform_sphere};

    /// A quadrature that is exact for polynomials of low degree: Gauss-Legendre in z, uniform in
    /// azimuth.
    fn sphere_quadrature(mut f: impl FnMut(Vec3, f64)) {
        // Four nodes: exact to degree 7.
        const NODES: [(f64, f64); 4] = [
            (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
            (-0.339_981_043_584_856_26, 0.652_145_154_862_546_2),
            (0.339_981_043_584_856_26, 0.652_145_154_862_546_2),
            (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        ];
        for (z, weight) in NODES {
            for k in 0..8 {
                let phi = std::f64::consts::TAU * f64::from(k) / 8.0;
                let r = (1.0 - z * z).sqrt();
                let d = Vec3::new((r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32);
                f(d, weight * std::f64::consts::TAU / 8.0);
            }
        }
    }

    #[test]
    fn the_basis_is_orthonormal() {
        let mut products = [[0.0_f64; 9]; 9];
        sphere_quadrature(|d, weight| {
            let y = sh_basis(d);
            for i in 0..9 {
                for j in 0..9 {
                    products[i][j] += weight * f64::from(y[i] * y[j]);
                }
            }
        });
        for (i, row) in products.iter().enumerate() {
            for (j, p) in row.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((p - expected).abs() < 1e-5, "({i}, {j}): {p}");
            }
        }
    }

    /// A constant sky gives E = π L for every normal and E / π = L on every face of the cube.
    #[test]
    fn a_constant_sky_gives_pi_times_its_radiance() {
        let sky = Vec3::new(1.0, 2.0, 0.5);
        let mut sh = ShRgb::ZERO;
        sphere_quadrature(|d, weight| sh.add_direction(d, sky * weight as f32));
        let mut rng = Rng::new(5, 0);
        for _ in 0..100 {
            let n = uniform_sphere(rng.next_2d().into());
            assert!(sh.irradiance(n).distance(sky * PI) < 1e-4);
            assert!(sh.radiance(n).distance(sky) < 1e-4);
        }
        assert!(sh.ambient_cube().iter().all(|face| face.distance(sky) < 1e-4));
    }

    /// L = 1 + d·a + (d·a)²: band-limited, so the irradiance is exact. For the normal a:
    /// ∫ cos = π, ∫ cos² = 2π/3, ∫ cos³ = π/2 over the upper hemisphere.
    #[test]
    fn irradiance_of_a_polynomial_is_exact() {
        let mut rng = Rng::new(6, 0);
        for _ in 0..20 {
            let a = uniform_sphere(rng.next_2d().into());
            let mut sh = ShRgb::ZERO;
            sphere_quadrature(|d, weight| {
                let cos = d.dot(a);
                sh.add_direction(d, Vec3::splat((1.0 + cos + cos * cos) * weight as f32));
            });
            let expected = PI + 2.0 * PI / 3.0 + PI / 2.0;
            assert!((sh.irradiance(a).x - expected).abs() < 1e-4, "{}", sh.irradiance(a).x);
            let behind = PI - 2.0 * PI / 3.0 + PI / 2.0;
            assert!((sh.irradiance(-a).x - behind).abs() < 1e-4, "{}", sh.irradiance(-a).x);
        }
    }

    /// Faces of the cube that would be negative are black.
    #[test]
    fn the_ambient_cube_is_never_negative() {
        let mut sh = ShRgb::ZERO;
        sh.add_direction(Vec3::X, Vec3::splat(3.0));
        let cube = sh.ambient_cube();
        assert!(cube.iter().all(|face| face.cmpge(Vec3::ZERO).all()));
        assert!(cube[0].x > 0.5 && cube[1].x < 0.1, "{cube:?}");
    }
}
