//! Real spherical harmonics to order 2.

use glam::Vec3;

/// Nine RGB coefficients of a real orthonormal basis without Condon-Shortley phase, order (0,0),
/// (1,-1), (1,0), (1,1), (2,-2) .. (2,2), z the polar axis of the formulas; of incident radiance
/// (not convolved with the cosine).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShRgb(pub [Vec3; 9]);
