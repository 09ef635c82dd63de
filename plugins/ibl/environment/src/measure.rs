//! How well lights replace their map.
//!
//! The measure is diffuse irradiance without shadows, of normals that are spread evenly over the sphere.

use glam::Vec3;

use crate::{Environment, EnvironmentLight};

/// `count` unit vectors, evenly over the sphere (a Fibonacci sphere; Á. González, *Measurement of Areas
/// on a Sphere Using Fibonacci and Latitude-Longitude Lattices*, Mathematical Geosciences 42, 2010).
#[must_use]
pub fn fibonacci_sphere(count: usize) -> Vec<Vec3> {
    let golden_section = 0.5 * (5.0_f64.sqrt() - 1.0);
    (0..count)
        .map(|at| {
            let y = 1.0 - (2 * at + 1) as f64 / count as f64;
            let azimuth = std::f64::consts::TAU * (at as f64 * golden_section).fract();
            crate::sphere::direction(azimuth, y).as_vec3()
        })
        .collect()
}

/// Irradiance of a surface with this unit normal that nothing shades, in the lights' unit.
#[must_use]
pub fn irradiance(lights: &[EnvironmentLight], normal: Vec3) -> Vec3 {
    let lit = |light: &EnvironmentLight| light.irradiance * light.direction.dot(normal).max(0.0);
    lights.iter().map(lit).sum()
}

/// Normals, and their irradiance under a map.
#[derive(Clone, Debug)]
pub struct Truth {
    normals: Vec<Vec3>,
    irradiances: Vec<Vec3>,
}

impl Truth {
    /// Of `count` normals ([`fibonacci_sphere`]). Left out are those which the map doesn't light, or by
    /// less than a millionth of what lights the brightest: no error is relative to nothing.
    #[must_use]
    pub fn new(map: &Environment, count: usize) -> Self {
        let mut normals = fibonacci_sphere(count);
        let mut irradiances: Vec<Vec3> = normals.iter().map(|n| map.irradiance(*n)).collect();
        let brightest = irradiances.iter().map(|e| e.element_sum()).fold(0.0, f32::max);
        let is_lit = |irradiance: &Vec3| irradiance.element_sum() > 1e-6 * brightest;
        let mut lit = irradiances.iter().map(is_lit).collect::<Vec<_>>().into_iter();
        normals.retain(|_| lit.next().unwrap_or(false));
        irradiances.retain(is_lit);
        Self { normals, irradiances }
    }

    /// The normals; none under a black map.
    #[must_use]
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Irradiance of the normals under the map.
    #[must_use]
    pub fn irradiances(&self) -> &[Vec3] {
        &self.irradiances
    }

    /// Irradiance of a normal under lights over that under the map, for each of the normals; channels
    /// are added up.
    #[must_use]
    pub fn ratios(&self, lights: &[EnvironmentLight]) -> Vec<f64> {
        let sum = |rgb: Vec3| f64::from(rgb.element_sum());
        (self.normals.iter().zip(&self.irradiances))
            .map(|(normal, exact)| sum(irradiance(lights, *normal)) / sum(*exact))
            .collect()
    }

    /// The error of lights. 0 under a black map.
    #[must_use]
    pub fn error(&self, lights: &[EnvironmentLight]) -> Error {
        let errors: Vec<f64> = self.ratios(lights).into_iter().map(|ratio| ratio - 1.0).collect();
        let mean = |sum: f64| if errors.is_empty() { 0.0 } else { sum / errors.len() as f64 };
        Error {
            mean: mean(errors.iter().map(|e| e.abs()).sum()),
            signed: mean(errors.iter().sum()),
        }
    }
}

/// Relative error of irradiance, 0.01 for 1 %.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Error {
    /// Mean over the normals of the absolute value.
    pub mean: f64,
    /// Mean over the normals with its sign.
    pub signed: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_relative_to_the_map() {
        let map = Environment::from_equirect(2, 1, vec![Vec3::new(1.0, 0.0, 2.0); 2]).unwrap();
        let truth = Truth::new(&map, 64);
        assert_eq!(truth.normals().len(), 64);
        // Light from six sides is 1.5 times too bright along the axes, and less elsewhere.
        let lights = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z].map(|direction| {
            let energy = 4.0 * std::f32::consts::PI * Vec3::new(1.0, 0.0, 2.0);
            EnvironmentLight { direction, irradiance: energy / 6.0 }
        });
        let error = truth.error(&lights);
        // The mean over the sphere of |x| + |y| + |z| is 3 / 2.
        assert!(error.signed.abs() < 0.01 && error.mean > 0.03, "{error:?}");
        let twice = lights.map(|l| EnvironmentLight { irradiance: 2.0 * l.irradiance, ..l });
        assert!((truth.error(&twice).signed - 1.0).abs() < 0.02);
    }

    #[test]
    fn unlit_normals_are_left_out() {
        let black = Environment::from_equirect(2, 1, vec![Vec3::ZERO; 2]).unwrap();
        let truth = Truth::new(&black, 64);
        assert!(truth.normals().is_empty());
        assert_eq!(truth.error(&[]), Error::default());
        // Light from straight above only.
        let mut texels = vec![Vec3::ZERO; 256 * 128];
        texels[..256].fill(Vec3::ONE);
        let above = Environment::from_equirect(256, 128, texels).unwrap();
        let truth = Truth::new(&above, 64);
        assert!((30..36).contains(&truth.normals().len()), "{}", truth.normals().len());
    }
}
