//! Maps from the unit square to directions.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use glam::{Vec2, Vec3};

/// Maps the unit square to the unit disk, keeping areas and neighbourhoods (Shirley and Chiu 1997).
#[must_use]
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let p = u * 2.0 - 1.0;
    if p == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    };
    let (sin, cos) = angle.sin_cos();
    Vec2::new(cos, sin) * radius
}

/// A unit direction about +z with density cos θ / π.
#[must_use]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let disk = concentric_disk(u);
    disk.extend((1.0 - disk.length_squared()).max(0.0).sqrt())
}

/// A unit direction with density 1 / 4π.
#[must_use]
pub fn uniform_sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * u.y).sin_cos();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Two unit vectors that make a right-handed orthonormal frame with a normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Local x.
    pub tangent: Vec3,
    /// Local y.
    pub bitangent: Vec3,
    /// Local z.
    pub normal: Vec3,
}

impl Frame {
    /// A frame about a unit normal, without branches (Duff et al. 2017, "Building an Orthonormal
    /// Basis, Revisited").
    #[must_use]
    pub fn new(normal: Vec3) -> Self {
        let sign = 1.0_f32.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// From local coordinates to the world.
    #[must_use]
    pub fn to_world(&self, local: Vec3) -> Vec3 {
        self.tangent * local.x + self.bitangent * local.y + self.normal * local.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Rng;

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        let mut rng = Rng::new(3, 0);
        let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
        let random = (0..1000).map(|_| uniform_sphere(rng.next_2d().into()));
        for n in axes.into_iter().chain(random) {
            let f = Frame::new(n);
            assert!((f.tangent.length() - 1.0).abs() < 1e-5, "{n}");
            assert!((f.bitangent.length() - 1.0).abs() < 1e-5, "{n}");
            assert!(f.tangent.dot(n).abs() < 1e-5 && f.tangent.dot(f.bitangent).abs() < 1e-5);
            assert!(f.tangent.cross(f.bitangent).distance(n) < 1e-5, "{n}");
        }
    }

    /// First and second moments against their integrals, in standard errors.
    #[test]
    fn directions_have_their_density() {
        let n = 200_000;
        let mut rng = Rng::new(11, 0);
        let mut sums = [0.0_f64; 4];
        for _ in 0..n {
            let c = cosine_hemisphere(rng.next_2d().into());
            let s = uniform_sphere(rng.next_2d().into());
            assert!((c.length() - 1.0).abs() < 1e-4 && c.z >= 0.0);
            assert!((s.length() - 1.0).abs() < 1e-4);
            for (sum, x) in sums.iter_mut().zip([c.z, c.x * c.x, s.z, s.x * s.x]) {
                *sum += f64::from(x);
            }
        }
        // Mean and variance of: cos θ and x² under cos θ / π; z and x² under 1 / 4π.
        let expected = [
            (2.0 / 3.0, 1.0 / 2.0 - 4.0 / 9.0),
            (1.0 / 4.0, 1.0 / 8.0 - 1.0 / 16.0),
            (0.0, 1.0 / 3.0),
            (1.0 / 3.0, 1.0 / 5.0 - 1.0 / 9.0),
        ];
        for (i, (sum, (mean, variance))) in sums.iter().zip(expected).enumerate() {
            let z = (sum / f64::from(n) - mean) / f64::sqrt(variance / f64::from(n));
            assert!(z.abs() < 4.0, "moment {i}: z = {z}");
        }
    }
}
