//! What light travels through: meshes, instances, materials, lights and the sky.
//!
//! Everything has a stable id chosen by the caller (an engine's entity or asset, a glTF node), so
//! that a scene can be changed piecewise ([`SceneChange`]) and sent over a wire once. Heavy data is
//! behind [`Arc`]: cloning a scene costs its tables, not its triangles.

mod change;
mod light;
mod material;
mod mesh;
mod sky;

pub use change::SceneChange;
pub use light::{Light, LightKind, LightSample};
pub use material::{AlphaMode, Material, Texture};
pub use mesh::{Mesh, MeshProblem};
pub use sky::{DirectSky, Sky, SkyImage};

use std::{collections::BTreeMap, sync::Arc};

use glam::Affine3A;

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u64);
    };
}

id!(/// Identifies a mesh; chosen by the caller, stable over the scene's life.
    MeshId);
id!(/// Identifies a texture.
    TextureId);
id!(/// Identifies a material.
    MaterialId);
id!(/// Identifies an instance: one mesh, one material, one place.
    InstanceId);
id!(/// Identifies a light.
    LightId);

/// A mesh placed in the world with one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// The geometry.
    pub mesh: MeshId,
    /// The material of all its triangles; [`Material::default`] is used while it is missing.
    pub material: MaterialId,
    /// From the mesh's space to the world, in metres. May mirror.
    pub transform: Affine3A,
}

/// A whole scene. The maps are ordered, so that results do not depend on hash seeds.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Geometry, shared between instances.
    pub meshes: BTreeMap<MeshId, Arc<Mesh>>,
    /// Images that materials refer to.
    pub textures: BTreeMap<TextureId, Arc<Texture>>,
    /// Surface descriptions.
    pub materials: BTreeMap<MaterialId, Material>,
    /// What is placed where. Only these are lit, block and reflect light.
    pub instances: BTreeMap<InstanceId, Instance>,
    /// Punctual lights.
    pub lights: BTreeMap<LightId, Light>,
    /// What a ray sees that leaves the scene.
    pub sky: Sky,
    /// Whether texels and probes hold what arrives straight from the sky.
    pub direct_sky: DirectSky,
}
