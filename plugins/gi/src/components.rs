//! What a game puts on its entities.

use bevy::{math::UVec3, prelude::*};

/// Tags an entity and everything below it, now and later, as static geometry that blocks, reflects
/// and receives indirect light. The root of a loaded glTF file is the usual place.
///
/// Each visible mesh below the tag with a `StandardMaterial`, or a `DiffuseReflectance` of
/// `farlight_core` in its place, gets a `Lightmap`. Meshes that can't take part are named in [`GiStatus::left_out`](crate::GiStatus::left_out), with the reason.
///
/// Meshes with baked light (`BakedSurface` of `farlight_core`) block and reflect light and keep the
/// lightmap that they have.
///
/// A [`GiDynamic`] further down takes its entity and what is below it out again.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct GiScene;

/// Tags an entity and everything below it as moving: it isn't part of the static scene and is lit
/// by the [`GiProbeVolume`] it is in. Meshes outside of any [`GiScene`] are dynamic anyway.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct GiDynamic;

/// A box of light probes that lights what has no lightmap.
///
/// The entity's `Transform` scales the unit cube to the box; choose it a little larger than the
/// space in which things move. The plugin adds Bevy's `LightProbe` and `IrradianceVolume`.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
#[require(Transform, Visibility)]
pub struct GiProbeVolume {
    /// Probes along x, y and z of the box; one every 0.5 to 1 m is usual. Each at least 1, together
    /// at most [`Self::MAX_PROBES`].
    pub resolution: UVec3,
}

impl GiProbeVolume {
    /// Most probes in one volume.
    pub const MAX_PROBES: u32 = 1 << 18;

    /// Why the resolution can't be used, if so.
    pub(crate) fn problem(&self) -> Option<String> {
        // The ambient cube is stored in a texture of (x, 2 y, 3 z) texels; 2048 is what every
        // desktop GPU offers along an edge of a 3D texture.
        let texture = self.resolution.saturating_mul(UVec3::new(1, 2, 3));
        if self.resolution.min_element() == 0 {
            return Some(format!("a probe volume of {} has no probes", self.resolution));
        }
        let probes = self.resolution.as_u64vec3().element_product();
        if texture.max_element() > 2048 || probes > u64::from(Self::MAX_PROBES) {
            return Some(format!(
                "a probe volume of {} is too large: at most {} probes, and 2048 x 1024 x 682",
                self.resolution,
                Self::MAX_PROBES
            ));
        }
        None
    }
}

impl Default for GiProbeVolume {
    fn default() -> Self {
        Self { resolution: UVec3::splat(4) }
    }
}

/// On every mesh entity that a [`GiScene`] covers. The plugin adds and removes it; read it, don't
/// write it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GiStatic;
