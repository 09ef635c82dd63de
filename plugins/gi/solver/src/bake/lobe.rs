//! How directions are drawn at a point.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec3};

use crate::sampling::{Frame, cosine_hemisphere, uniform_sphere};

/// A distribution of unit directions.
pub(super) trait Lobe {
    /// The direction for a point of the unit square, and its density per solid angle.
    fn draw(&self, u: Vec2) -> (Vec3, f32);
    /// The density of a direction.
    fn pdf(&self, direction: Vec3) -> f32;
}

/// cos θ / π around a normal.
pub(super) struct Cosine {
    frame: Frame,
}

/// cos θ / π around a shading normal; what would go below the surface is mirrored at it.
///
/// So the surface doesn't darken what its shading normal tilts towards it: under light that is the same
/// from everywhere the irradiance is π times its radiance, as on a flat surface, and nothing jumps where
/// triangles meet. With the geometric normal as shading normal it is [`Cosine`].
pub(super) struct Bent {
    frame: Frame,
    geometric: Vec3,
}

/// The same density everywhere.
pub(super) struct Sphere;

impl Cosine {
    pub(super) fn new(normal: Vec3) -> Self {
        Self { frame: Frame::new(normal) }
    }
}

impl Lobe for Cosine {
    fn draw(&self, u: Vec2) -> (Vec3, f32) {
        let local = cosine_hemisphere(u);
        (self.frame.to_world(local), local.z * FRAC_1_PI)
    }

    fn pdf(&self, direction: Vec3) -> f32 {
        self.frame.normal.dot(direction).max(0.0) * FRAC_1_PI
    }
}

impl Bent {
    pub(super) fn new(shading: Vec3, geometric: Vec3) -> Self {
        Self { frame: Frame::new(shading), geometric }
    }

    /// What irradiance weighs radiance from a direction with: the cosine, and that of the mirrored one.
    pub(super) fn weight(&self, direction: Vec3) -> f32 {
        self.pdf(direction) * PI
    }

    fn mirrored(&self, direction: Vec3) -> Vec3 {
        direction - self.geometric * (2.0 * self.geometric.dot(direction))
    }
}

impl Lobe for Bent {
    fn draw(&self, u: Vec2) -> (Vec3, f32) {
        let mut direction = self.frame.to_world(cosine_hemisphere(u));
        if self.geometric.dot(direction) < 0.0 {
            direction = self.mirrored(direction);
        }
        (direction, self.pdf(direction))
    }

    fn pdf(&self, direction: Vec3) -> f32 {
        if self.geometric.dot(direction) < 0.0 {
            return 0.0;
        }
        let cos = |d: Vec3| self.frame.normal.dot(d).max(0.0);
        (cos(direction) + cos(self.mirrored(direction))) * FRAC_1_PI
    }
}

impl Lobe for Sphere {
    fn draw(&self, u: Vec2) -> (Vec3, f32) {
        (uniform_sphere(u), Self.pdf(Vec3::X))
    }

    fn pdf(&self, _: Vec3) -> f32 {
        0.25 * FRAC_1_PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Rng;

    /// Densities integrate to 1 over the side that is seen, and are those of the directions.
    #[test]
    fn densities_are_those_of_directions() {
        let g = Vec3::new(1.0, 2.0, 3.0).normalize();
        let tilted = (g + g.any_orthonormal_vector() * 1.5).normalize();
        let n = 200_000_u32;
        let check = |lobe: &dyn Lobe, what: &str| {
            let mut rng = Rng::new(1, 0);
            let (mut sphere, mut drawn) = ([0.0_f64; 2], 0.0_f64);
            // A test function that is smooth over the side that is seen.
            let f = |d: Vec3| f64::from(1.0 + d.dot(tilted) + d.x * d.y);
            for _ in 0..n {
                let d = uniform_sphere(rng.next_2d().into());
                let pdf = f64::from(lobe.pdf(d)) * 4.0 * std::f64::consts::PI;
                sphere[0] += pdf;
                sphere[1] += pdf * f(d);
                let (d, pdf) = lobe.draw(rng.next_2d().into());
                assert!((lobe.pdf(d) - pdf).abs() < 1e-5, "{what}");
                drawn += f(d);
            }
            let [one, mean] = sphere.map(|s| s / f64::from(n));
            let drawn = drawn / f64::from(n);
            assert!((one - 1.0).abs() < 0.015, "{what}: {one}");
            assert!((mean - drawn).abs() < 0.03, "{what}: {mean} {drawn}");
        };
        check(&Cosine::new(g), "cosine");
        check(&Bent::new(g, g), "flat");
        check(&Bent::new(tilted, g), "bent");
        check(&Sphere, "sphere");
    }

    #[test]
    fn a_flat_lobe_is_the_cosine() {
        let g = Vec3::new(-1.0, 2.0, 0.5).normalize();
        let (flat, cosine) = (Bent::new(g, g), Cosine::new(g));
        let mut rng = Rng::new(2, 0);
        for _ in 0..1000 {
            let u = Vec2::from(rng.next_2d());
            assert!((flat.draw(u).0 - cosine.draw(u).0).length() < 1e-5);
        }
    }
}
