//! What a ray sees that leaves the scene.

use std::{f32::consts::PI, sync::Arc};

use glam::{Quat, Vec3};

/// The environment around the scene.
#[derive(Clone, Debug)]
pub enum Sky {
    /// The same radiance from everywhere; black is no sky.
    Constant(Vec3),
    /// An equirectangular image, turned by a rotation from the image's frame to the world.
    Image {
        /// The picture.
        image: Arc<SkyImage>,
        /// From the image's frame to the world.
        rotation: Quat,
        /// Multiplies the image's values into the scene's radiance unit.
        scale: f32,
    },
}

impl Default for Sky {
    fn default() -> Self {
        Self::Constant(Vec3::ZERO)
    }
}

/// Whether what arrives straight from the sky belongs to what is solved for. What surfaces reflect of
/// it always does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DirectSky {
    /// Texels and probes hold it.
    #[default]
    Included,
    /// They do not: somebody else shows it, for example by directional lights made from the sky.
    LeftOut,
}

/// An equirectangular image of radiance: `u = 0.5 + atan2(x, -z) / 2π`, `v = acos(y) / π`; the
/// centre is -z, right is +x, row 0 is up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkyImage {
    /// Texels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` linear RGB values, finite and not negative.
    pub texels: Vec<Vec3>,
}

impl PartialEq for Sky {
    /// Images that are the same memory are equal without a look at their texels, so that asking
    /// whether a sky that only turns is another one costs nothing.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Constant(a), Self::Constant(b)) => a == b,
            (
                Self::Image { image: a, rotation: turned_a, scale: scale_a },
                Self::Image { image: b, rotation: turned_b, scale: scale_b },
            ) => turned_a == turned_b && scale_a == scale_b && (Arc::ptr_eq(a, b) || a == b),
            _ => false,
        }
    }
}

impl Sky {
    /// Whether nothing comes from it.
    #[must_use]
    pub fn is_black(&self) -> bool {
        match self {
            Self::Constant(radiance) => *radiance == Vec3::ZERO,
            Self::Image { image, scale, .. } => image.texels.is_empty() || *scale == 0.0,
        }
    }

    /// Radiance that arrives from the unit direction `direction` (pointing away from the receiver).
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Constant(radiance) => *radiance,
            Self::Image { image, rotation, scale } => {
                image.sample(rotation.inverse() * direction) * *scale
            }
        }
    }
}

impl SkyImage {
    /// Column and row of the texel in a unit direction of the image's own frame. The image must not
    /// be empty.
    pub(crate) fn texel_at(&self, d: Vec3) -> (u32, u32) {
        let u = 0.5 + d.x.atan2(-d.z) / (2.0 * PI);
        let v = d.y.clamp(-1.0, 1.0).acos() / PI;
        let x = ((u * self.width as f32) as u32).min(self.width - 1);
        let y = ((v * self.height as f32) as u32).min(self.height - 1);
        (x, y)
    }

    /// Nearest texel in a direction of the image's own frame.
    fn sample(&self, d: Vec3) -> Vec3 {
        if self.texels.is_empty() {
            return Vec3::ZERO;
        }
        let (x, y) = self.texel_at(d);
        self.texels[(y * self.width + x) as usize]
    }
}
