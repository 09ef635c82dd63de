//! The one sky.

use std::borrow::Cow;

use bevy::{math::Vec3, prelude::*};
use thiserror::Error;

/// What arrives from far away, in cd/m².
#[derive(Clone, Debug, PartialEq)]
pub enum SkyRadiance {
    /// The same linear Rec. 709 radiance from every direction; black is no sky.
    Constant(Vec3),
    /// An equirectangular image: `u = 0.5 + atan2(x, -z) / 2π`, `v = acos(y) / π`; the centre is -z,
    /// right is +x, row 0 is up.
    Equirect {
        /// The picture. It needs its data on the CPU (`RenderAssetUsages::MAIN_WORLD`).
        image: Handle<Image>,
        /// From the image's frame to the world.
        rotation: Quat,
        /// Multiplies the image's linear values into cd/m².
        brightness: f32,
    },
}

/// The sky that lights the scene. There is one an app, so that plugins which solve or show lighting
/// count it once.
///
/// Whoever provides the sky [claims](Self::claim) it; everybody else only reads.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct SkySource {
    /// Its light.
    pub radiance: SkyRadiance,
    owner: Option<Cow<'static, str>>,
}

/// Somebody else provides the sky already.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("the sky belongs to {owner}; {asked} can't replace it")]
pub struct SkyTaken {
    /// Who has it.
    pub owner: Cow<'static, str>,
    /// Who asked for it.
    pub asked: Cow<'static, str>,
}

impl Default for SkySource {
    /// No sky, nobody's.
    fn default() -> Self {
        Self { radiance: SkyRadiance::Constant(Vec3::ZERO), owner: None }
    }
}

impl SkySource {
    /// A constant sky of linear radiance in cd/m², provided by the game itself.
    #[must_use]
    pub fn constant(radiance: Vec3) -> Self {
        Self { radiance: SkyRadiance::Constant(radiance), owner: None }
    }

    /// An equirectangular sky, provided by the game itself.
    #[must_use]
    pub fn equirect(image: Handle<Image>, rotation: Quat, brightness: f32) -> Self {
        Self { radiance: SkyRadiance::Equirect { image, rotation, brightness }, owner: None }
    }

    /// Replaces the sky in the name of `owner` (a plugin's name). It stays the owner's until
    /// [`release`](Self::release).
    ///
    /// # Errors
    /// [`SkyTaken`] if it belongs to another owner.
    pub fn claim(
        &mut self,
        owner: impl Into<Cow<'static, str>>,
        radiance: SkyRadiance,
    ) -> Result<(), SkyTaken> {
        let asked = owner.into();
        match &self.owner {
            Some(owner) if *owner != asked => Err(SkyTaken { owner: owner.clone(), asked }),
            _ => {
                self.owner = Some(asked);
                self.radiance = radiance;
                Ok(())
            }
        }
    }

    /// Gives the sky back if it is `owner`'s; its light stays until somebody replaces it.
    pub fn release(&mut self, owner: &str) {
        if self.owner.as_deref() == Some(owner) {
            self.owner = None;
        }
    }

    /// Who provides the sky; `None` is the game itself.
    #[must_use]
    pub fn owner(&self) -> Option<&str> {
        self.owner.as_deref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claimed_sky_is_not_replaced_by_another_owner() {
        let mut sky = SkySource::default();
        let white = SkyRadiance::Constant(Vec3::ONE);
        sky.claim("ibl", white.clone()).unwrap();
        let refused = sky.claim("weather", SkyRadiance::Constant(Vec3::ZERO)).unwrap_err();
        assert_eq!(refused.owner, "ibl");
        assert_eq!(sky.radiance, white);
        sky.claim("ibl", SkyRadiance::Constant(Vec3::X)).unwrap();
        sky.release("weather");
        assert_eq!(sky.owner(), Some("ibl"));
        sky.release("ibl");
        sky.claim("weather", SkyRadiance::Constant(Vec3::ZERO)).unwrap();
    }
}
