//! Directions, and where they fall among the samples.
//!
//! A direction is given in the frame of the surface: x along the columns of the picture (azimuth
//! 0), z along the normal. Azimuths run from x towards y.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::Vec3;

/// Directions of light and view in radians: `theta` from the normal, `phi` round it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Angles {
    /// Elevation of the light.
    pub theta_i: f32,
    /// Azimuth of the light.
    pub phi_i: f32,
    /// Elevation of the view.
    pub theta_v: f32,
    /// Azimuth of the view.
    pub phi_v: f32,
}

impl Angles {
    /// From degrees, reduced before the conversion, so that whole turns and grid directions stay
    /// exact.
    pub fn from_degrees(theta_i: f64, phi_i: f64, theta_v: f64, phi_v: f64) -> Self {
        let turn = |phi: f64| phi.rem_euclid(360.0).to_radians() as f32;
        Self {
            theta_i: theta_i.to_radians() as f32,
            phi_i: turn(phi_i),
            theta_v: theta_v.to_radians() as f32,
            phi_v: turn(phi_v),
        }
    }

    /// Of two unit vectors in the frame of the surface, away from it.
    pub fn from_directions(light: Vec3, view: Vec3) -> Self {
        let theta = |d: Vec3| d.truncate().length().atan2(d.z);
        let phi = |d: Vec3| d.y.atan2(d.x);
        Self { theta_i: theta(light), phi_i: phi(light), theta_v: theta(view), phi_v: phi(view) }
    }

    /// Whether both directions are above the surface, or in it.
    pub fn above(&self) -> bool {
        self.theta_i <= FRAC_PI_2 && self.theta_v <= FRAC_PI_2
    }
}

/// The light's direction as the tables know it: round the axis that lies in the surface across the
/// view ("onion slices": Havran et al. 2010, section 3).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SliceAngles {
    /// Angle of the light out of the plane of normal and view, -pi/2 to pi/2.
    pub beta: f32,
    /// Sine of beta, exact where beta is not.
    pub sin_beta: f32,
    /// Tilt of the light's arc, -pi/2 (the side of the view) to pi/2 (the mirror side).
    pub alpha: f32,
}

/// Below this cosine of beta, [`Rules::guard_beta_pole`](crate::Rules) takes alpha for 0.
pub(crate) const BETA_POLE: f32 = 0.001;

impl SliceAngles {
    /// Of a light that stands `difference` (phi of the light less phi of the view) round the
    /// normal from the view.
    pub fn new(theta_i: f32, difference: f32, guard_beta_pole: bool) -> Self {
        let (sin_theta, cos_theta) = theta_i.sin_cos();
        let (sin, cos) = difference.sin_cos();
        Self::from_vector(-sin * sin_theta, -cos * sin_theta, cos_theta, guard_beta_pole)
    }

    /// Of a light whose unit vector is (`across`, `mirror`, `up`) on the axes "across the view",
    /// "away from the view" and normal.
    ///
    /// Arc tangents instead of the arc sines of the definition: they lose no digits at the horizon.
    pub fn from_vector(across: f32, mirror: f32, up: f32, guard_beta_pole: bool) -> Self {
        let up = up.max(0.0);
        let cos_beta = mirror.hypot(up);
        let guarded = guard_beta_pole && cos_beta < BETA_POLE;
        Self {
            beta: across.atan2(cos_beta),
            sin_beta: across,
            alpha: if guarded || cos_beta == 0.0 { 0.0 } else { mirror.atan2(up) },
        }
    }

    /// The unit vector on the axes of [`SliceAngles::from_vector`].
    pub fn to_vector(self) -> Vec3 {
        let cos_beta = self.beta.cos();
        Vec3::new(self.beta.sin(), self.alpha.sin() * cos_beta, self.alpha.cos() * cos_beta)
    }
}

/// Two neighbouring samples of an axis, and how far one is between them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    /// The lower sample.
    pub low: u32,
    /// The upper sample: `low + 1`, or 0 where the axis is a circle and ends.
    pub high: u32,
    /// Weight of the upper sample, 0 to 1.
    pub weight: f32,
}

impl Cell {
    /// Among `count` samples from `first` to `last`, both included.
    pub fn between(value: f32, first: f32, last: f32, count: u32) -> Self {
        let at = (value - first) * ((count - 1) as f32 / (last - first));
        let low = (at.max(0.0) as u32).min(count - 2);
        Self { low, high: low + 1, weight: (at - low as f32).clamp(0.0, 1.0) }
    }

    /// Among `count` samples round a circle from 0 on.
    pub fn round(angle: f32, count: u32) -> Self {
        let at = angle.rem_euclid(TAU) * (count as f32 / TAU);
        let low = (at as u32).min(count - 1);
        let high = if low + 1 == count { 0 } else { low + 1 };
        Self { low, high, weight: (at - low as f32).clamp(0.0, 1.0) }
    }

    /// Among `count` samples at equal steps of the sine; the weight is linear in the angle.
    pub fn in_sine(angles: SliceAngles, count: u32) -> Self {
        let half = (count - 1) as f32 * 0.5;
        let at = (angles.sin_beta + 1.0) * half;
        let low = (at.max(0.0) as u32).min(count - 2);
        let angle = |sample: u32| (sample as f32 / half - 1.0).clamp(-1.0, 1.0).asin();
        let (from, to) = (angle(low), angle(low + 1));
        let weight = ((angles.beta - from) / (to - from)).clamp(0.0, 1.0);
        Self { low, high: low + 1, weight }
    }
}

/// The stored azimuth of a view: it runs the other way round.
pub(crate) fn stored_azimuth(phi_v: f32) -> f32 {
    -phi_v
}
