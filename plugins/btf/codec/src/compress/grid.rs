//! The directions at which a material is sampled.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use crate::{Angles, SliceAngles};

/// Numbers of samples on the four axes of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Azimuths of the view, from 0 on round the circle.
    pub phi: usize,
    /// Elevations of the view, from 0 to 90 degrees.
    pub theta: usize,
    /// Angles alpha of the light, from -90 to 90 degrees.
    pub alpha: usize,
    /// Angles beta of the light, from -90 to 90 degrees.
    pub beta: usize,
    /// Whether beta is sampled at equal steps of its sine.
    pub beta_uniform_in_sine: bool,
}

impl Default for Grid {
    /// As the materials of the BTFbase format are sampled.
    fn default() -> Self {
        Self { phi: 16, theta: 7, alpha: 11, beta: 11, beta_uniform_in_sine: true }
    }
}

impl Grid {
    /// Samples of a texel.
    pub fn samples(&self) -> usize {
        self.phi * self.theta * self.slice()
    }

    /// Samples of one direction of view.
    pub(crate) fn slice(&self) -> usize {
        self.alpha * self.beta
    }

    /// Elevation and azimuth of a view, in radians.
    pub fn view(&self, phi: usize, theta: usize) -> [f32; 2] {
        let elevation = FRAC_PI_2 * theta as f32 / (self.theta - 1) as f32;
        // The stored azimuth runs the other way round.
        let azimuth = TAU * ((self.phi - phi) % self.phi) as f32 / self.phi as f32;
        [elevation, azimuth]
    }

    /// Where the light of a sample stands, on the axes of the view.
    pub fn light(&self, alpha: usize, beta: usize) -> SliceAngles {
        let beta_at = beta as f32 / (self.beta - 1) as f32;
        let sine = (2.0 * beta_at - 1.0).clamp(-1.0, 1.0);
        let beta = if self.beta_uniform_in_sine { sine.asin() } else { PI * beta_at - FRAC_PI_2 };
        SliceAngles {
            beta,
            sin_beta: if self.beta_uniform_in_sine { sine } else { beta.sin() },
            alpha: PI * alpha as f32 / (self.alpha - 1) as f32 - FRAC_PI_2,
        }
    }

    /// The directions of a sample. Lights at the horizon are not above it by any rounding.
    pub fn angles(&self, phi: usize, theta: usize, alpha: usize, beta: usize) -> Angles {
        let [theta_v, phi_v] = self.view(phi, theta);
        let [across, mirror, up] = self.light(alpha, beta).to_vector().to_array();
        Angles {
            theta_i: across.hypot(mirror).atan2(up).min(FRAC_PI_2),
            // With the view at azimuth 0, the light is at (-mirror, -across).
            phi_i: (phi_v + (-across).atan2(-mirror)).rem_euclid(TAU),
            theta_v,
            phi_v,
        }
    }

    /// Place of a sample in a texel's list.
    pub fn index(&self, phi: usize, theta: usize, alpha: usize, beta: usize) -> usize {
        ((phi * self.theta + theta) * self.alpha + alpha) * self.beta + beta
    }
}
