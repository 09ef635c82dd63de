//! Piecewise changes of a scene.

use std::sync::Arc;

use super::{
    DirectSky, Instance, InstanceId, Light, LightId, Material, MaterialId, Mesh, MeshId, Scene,
    Sky, Texture, TextureId,
};

/// One change of a [`Scene`]. Setting an id that exists replaces what it named.
#[derive(Clone, Debug)]
pub enum SceneChange {
    /// Adds or replaces geometry.
    SetMesh(MeshId, Arc<Mesh>),
    /// Forgets geometry. Instances of it vanish from the solution.
    RemoveMesh(MeshId),
    /// Adds or replaces an image.
    SetTexture(TextureId, Arc<Texture>),
    /// Forgets an image; materials that use it fall back to their factors.
    RemoveTexture(TextureId),
    /// Adds or replaces a material.
    SetMaterial(MaterialId, Material),
    /// Forgets a material.
    RemoveMaterial(MaterialId),
    /// Adds, moves or alters an instance.
    SetInstance(InstanceId, Instance),
    /// Takes an instance out of the world.
    RemoveInstance(InstanceId),
    /// Adds, moves or alters a light.
    SetLight(LightId, Light),
    /// Takes a light out of the world.
    RemoveLight(LightId),
    /// Replaces the sky.
    SetSky(Sky),
    /// Says whether texels and probes hold what arrives straight from the sky.
    SetDirectSky(DirectSky),
}

impl SceneChange {
    /// Whether only emitted light changes (lights, sky): the geometry and its reflectance stay, so
    /// everything that was traced remains valid.
    #[must_use]
    pub fn is_light_only(&self) -> bool {
        matches!(
            self,
            Self::SetLight(..) | Self::RemoveLight(..) | Self::SetSky(..) | Self::SetDirectSky(..)
        )
    }
}

impl Scene {
    /// The changes that turn an empty scene into this one: what is named comes before what names it.
    pub fn changes(&self) -> impl Iterator<Item = SceneChange> {
        let textures = self.textures.iter().map(|(id, t)| SceneChange::SetTexture(*id, t.clone()));
        let materials =
            self.materials.iter().map(|(id, m)| SceneChange::SetMaterial(*id, m.clone()));
        let meshes = self.meshes.iter().map(|(id, m)| SceneChange::SetMesh(*id, m.clone()));
        let instances =
            self.instances.iter().map(|(id, i)| SceneChange::SetInstance(*id, i.clone()));
        let lights = self.lights.iter().map(|(id, l)| SceneChange::SetLight(*id, *l));
        let sky = std::iter::once_with(|| SceneChange::SetSky(self.sky.clone()));
        let sky = sky.chain([SceneChange::SetDirectSky(self.direct_sky)]);
        textures.chain(materials).chain(meshes).chain(instances).chain(lights).chain(sky)
    }

    /// Applies one change.
    pub fn apply(&mut self, change: SceneChange) {
        match change {
            SceneChange::SetMesh(id, mesh) => drop(self.meshes.insert(id, mesh)),
            SceneChange::RemoveMesh(id) => drop(self.meshes.remove(&id)),
            SceneChange::SetTexture(id, texture) => drop(self.textures.insert(id, texture)),
            SceneChange::RemoveTexture(id) => drop(self.textures.remove(&id)),
            SceneChange::SetMaterial(id, material) => drop(self.materials.insert(id, material)),
            SceneChange::RemoveMaterial(id) => drop(self.materials.remove(&id)),
            SceneChange::SetInstance(id, instance) => drop(self.instances.insert(id, instance)),
            SceneChange::RemoveInstance(id) => drop(self.instances.remove(&id)),
            SceneChange::SetLight(id, light) => drop(self.lights.insert(id, light)),
            SceneChange::RemoveLight(id) => drop(self.lights.remove(&id)),
            SceneChange::SetSky(sky) => self.sky = sky,
            SceneChange::SetDirectSky(direct) => self.direct_sky = direct,
        }
    }
}
