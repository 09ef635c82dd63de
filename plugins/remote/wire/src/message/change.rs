//! The objects that a scene is synchronized by.

use std::collections::BTreeMap;

use farlight_gi_solver::{
    scene::{
        DirectSky, Instance, InstanceId, Light, LightId, Material, MaterialId, MeshId, TextureId,
    },
    session::{GridId, ProbeGrid},
};
use glam::{Quat, Vec3};

use crate::BlobHash;

/// Names an object of the scene. The order is the one in which objects are sent: what is named comes
/// before what names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum ObjectKey {
    /// An image.
    Texture(TextureId),
    /// A material.
    Material(MaterialId),
    /// Geometry.
    Mesh(MeshId),
    /// An instance.
    Instance(InstanceId),
    /// That an instance has a lightmap.
    Receiver(InstanceId),
    /// A light.
    Light(LightId),
    /// The sky.
    Sky,
    /// Whether what arrives straight from the sky is solved for; it is where nothing is said.
    DirectSky,
    /// A probe grid.
    Grid(GridId),
}

/// The newest state of an object. Its variant is that of its key.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Object {
    /// The image's content.
    Texture(BlobHash),
    /// The parameters.
    Material(Material),
    /// The geometry's content.
    Mesh(BlobHash),
    /// Mesh, material, place.
    Instance(Instance),
    /// It has one.
    Receiver,
    /// The parameters.
    Light(Light),
    /// The sky.
    Sky(SkyObject),
    /// Whether what arrives straight from it is solved for.
    DirectSky(DirectSky),
    /// Place and resolution.
    Grid(ProbeGrid),
}

/// The sky, its image by content.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SkyObject {
    /// The same radiance from everywhere.
    Constant(Vec3),
    /// An image.
    Image {
        /// Its content.
        image: BlobHash,
        /// From the image's frame to the world.
        rotation: Quat,
        /// Multiplies its values.
        scale: f32,
    },
}

/// Probes of all grids among objects.
pub(crate) fn total_probes(objects: &BTreeMap<ObjectKey, Object>) -> usize {
    let grids = objects.range(ObjectKey::Grid(GridId(0))..);
    grids.fold(0, |sum, (_, object)| match object {
        Object::Grid(grid) => {
            let [x, y, z] = grid.resolution.to_array().map(|n| n as usize);
            sum.saturating_add(x.saturating_mul(y).saturating_mul(z))
        }
        _ => sum,
    })
}

impl Object {
    /// The blob that it needs.
    pub(crate) fn blob(&self) -> Option<BlobHash> {
        match self {
            Self::Texture(hash)
            | Self::Mesh(hash)
            | Self::Sky(SkyObject::Image { image: hash, .. }) => Some(*hash),
            _ => None,
        }
    }
}
