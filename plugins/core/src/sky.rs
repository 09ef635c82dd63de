//! The one sky.

use std::{borrow::Cow, ops::Deref};

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

/// Who shows the light that comes straight from the sky. What it does after its first bounce is
/// always the solver's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DirectSky {
    /// Whoever solves indirect light includes what comes straight from the sky.
    #[default]
    Solved,
    /// Lights marked [`DerivedLight`](crate::DerivedLight) show it, on every surface, also on those
    /// with lightmaps (`affects_lightmapped_mesh_diffuse`). Solvers leave it out of what they show
    /// and keep its bounces, so that it is counted once.
    ByLights,
}

/// The sky that lights the scene. There is one an app, so that plugins which solve or show lighting
/// count it once.
///
/// Whoever provides the sky [claims](Self::claim) it; everybody else only reads. Lighting is solved
/// again when it changes: write it only then.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct SkySource {
    /// Its light.
    pub radiance: SkyRadiance,
    /// Who shows what comes straight from it.
    pub direct: DirectSky,
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
        Self::constant(Vec3::ZERO)
    }
}

impl SkySource {
    /// A constant sky of linear radiance in cd/m², provided by the game itself.
    #[must_use]
    pub fn constant(radiance: Vec3) -> Self {
        Self { radiance: SkyRadiance::Constant(radiance), direct: DirectSky::Solved, owner: None }
    }

    /// An equirectangular sky, provided by the game itself.
    #[must_use]
    pub fn equirect(image: Handle<Image>, rotation: Quat, brightness: f32) -> Self {
        Self {
            radiance: SkyRadiance::Equirect { image, rotation, brightness },
            direct: DirectSky::Solved,
            owner: None,
        }
    }

    /// Replaces the sky in the name of `owner` (a plugin's name). It stays the owner's until
    /// [`release`](Self::release). `sky` is a [`ResMut`] or a [`Mut`]; it counts as changed only if
    /// it is another sky than before, so an owner may claim it every frame.
    ///
    /// ```
    /// # use bevy::{math::Vec3, prelude::*};
    /// # use farlight_core::{DirectSky, SkyRadiance, SkySource};
    /// fn overcast(mut sky: ResMut<SkySource>) {
    ///     let grey = SkyRadiance::Constant(Vec3::splat(4000.0));
    ///     if let Err(taken) = SkySource::claim(&mut sky, "weather", grey, DirectSky::Solved) {
    ///         warn_once!("{taken}");
    ///     }
    /// }
    /// # bevy::ecs::system::assert_is_system(overcast);
    /// ```
    ///
    /// # Errors
    /// [`SkyTaken`] if it belongs to another owner.
    pub fn claim(
        sky: &mut (impl DetectChangesMut<Inner = Self> + Deref<Target = Self>),
        owner: impl Into<Cow<'static, str>>,
        radiance: SkyRadiance,
        direct: DirectSky,
    ) -> Result<(), SkyTaken> {
        let asked = owner.into();
        match &sky.owner {
            Some(owner) if *owner != asked => Err(SkyTaken { owner: owner.clone(), asked }),
            _ => {
                sky.set_if_neq(Self { radiance, direct, owner: Some(asked) });
                Ok(())
            }
        }
    }

    /// Gives the sky back if it is `owner`'s. Its light stays until somebody replaces it; from now
    /// on it is solved as a whole, for the owner's lights no longer show a part of it.
    pub fn release(
        sky: &mut (impl DetectChangesMut<Inner = Self> + Deref<Target = Self>),
        owner: &str,
    ) {
        if sky.owner() == Some(owner) {
            let radiance = sky.radiance.clone();
            sky.set_if_neq(Self { radiance, direct: DirectSky::Solved, owner: None });
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

    fn constant(radiance: Vec3) -> SkyRadiance {
        SkyRadiance::Constant(radiance)
    }

    #[test]
    fn a_claimed_sky_is_not_replaced_by_another_owner() {
        let mut world = World::new();
        world.init_resource::<SkySource>();
        let mut sky = world.resource_mut::<SkySource>();
        SkySource::claim(&mut sky, "ibl", constant(Vec3::ONE), DirectSky::Solved).unwrap();
        let black = constant(Vec3::ZERO);
        let refused = SkySource::claim(&mut sky, "weather", black.clone(), DirectSky::Solved);
        assert_eq!(refused.unwrap_err().owner, "ibl");
        assert_eq!(sky.radiance, constant(Vec3::ONE));
        SkySource::claim(&mut sky, "ibl", constant(Vec3::X), DirectSky::ByLights).unwrap();
        SkySource::release(&mut sky, "weather");
        assert_eq!((sky.owner(), sky.direct), (Some("ibl"), DirectSky::ByLights));
        SkySource::release(&mut sky, "ibl");
        assert_eq!((sky.owner(), sky.direct), (None, DirectSky::Solved));
        assert_eq!(sky.radiance, constant(Vec3::X), "a sky that was given back stays");
        SkySource::claim(&mut sky, "weather", black, DirectSky::Solved).unwrap();
    }

    #[test]
    fn only_another_sky_looks_like_a_change() {
        let mut world = World::new();
        world.init_resource::<SkySource>();
        let mut claimed = |radiance: f32, direct| {
            world.clear_trackers();
            let mut sky = world.resource_mut::<SkySource>();
            SkySource::claim(&mut sky, "ibl", constant(Vec3::splat(radiance)), direct).unwrap();
            sky.is_changed()
        };
        assert!(claimed(1.0, DirectSky::Solved));
        assert!(!claimed(1.0, DirectSky::Solved));
        assert!(claimed(1.0, DirectSky::ByLights));
        assert!(!claimed(1.0, DirectSky::ByLights));
        assert!(claimed(2.0, DirectSky::ByLights));
        world.clear_trackers();
        let mut sky = world.resource_mut::<SkySource>();
        SkySource::release(&mut sky, "weather");
        assert!(!sky.is_changed(), "it was not the weather's");
        SkySource::release(&mut sky, "ibl");
        assert!(sky.is_changed());
    }
}
