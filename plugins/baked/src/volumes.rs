//! Bevy's irradiance volumes below a root.

use bevy::{light::IrradianceVolume, prelude::*};
use farlight_baked_format::manifest::Volume;

use crate::{BakedPart, textures::Shown};

/// A box of probes as a child of the root. Lightmapped meshes have that light already.
pub(crate) fn spawn(
    volume: &Volume,
    shown: &Shown,
    root: Entity,
    commands: &mut Commands,
) -> Entity {
    let volume_component = IrradianceVolume {
        voxels: shown.image.clone(),
        // Voxels hold E / π in cd/m², what Bevy multiplies with the diffuse colour.
        intensity: 1.0,
        affects_lightmapped_meshes: false,
    };
    let transform = Transform::from_matrix(volume.affine().into());
    let parts = (BakedPart, Name::new("baked probes"), transform, Visibility::default());
    commands.spawn((parts, volume_component, LightProbe::default(), ChildOf(root))).id()
}
