//! How large a scene is, from its changes.

use std::{
    collections::{HashMap, HashSet},
    fmt,
};

use farlight_gi_solver::{
    SceneChange,
    scene::{InstanceId, LightId, MeshId},
    session::SessionChange,
};

/// How much a session has to do with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneSize {
    /// Objects in the world.
    pub instances: usize,
    /// Triangles of all instances.
    pub triangles: usize,
    /// Punctual lights.
    pub lights: usize,
}

impl fmt::Display for SceneSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { instances, triangles, lights } = self;
        write!(f, "{instances} objects, {triangles} triangles, {lights} lights")
    }
}

/// Follows the changes of a scene.
#[derive(Debug, Default)]
pub(crate) struct Measure {
    meshes: HashMap<MeshId, usize>,
    instances: HashMap<InstanceId, MeshId>,
    lights: HashSet<LightId>,
}

impl Measure {
    pub(crate) fn follow(&mut self, changes: &[SessionChange]) {
        for change in changes {
            let SessionChange::Scene(change) = change else { continue };
            match change {
                SceneChange::SetMesh(id, mesh) => {
                    self.meshes.insert(*id, mesh.triangles.len());
                }
                SceneChange::RemoveMesh(id) => {
                    self.meshes.remove(id);
                }
                SceneChange::SetInstance(id, instance) => {
                    self.instances.insert(*id, instance.mesh);
                }
                SceneChange::RemoveInstance(id) => {
                    self.instances.remove(id);
                }
                SceneChange::SetLight(id, _) => {
                    self.lights.insert(*id);
                }
                SceneChange::RemoveLight(id) => {
                    self.lights.remove(id);
                }
                _ => {}
            }
        }
    }

    pub(crate) fn size(&self) -> SceneSize {
        let triangles = |mesh| self.meshes.get(mesh).copied().unwrap_or_default();
        SceneSize {
            instances: self.instances.len(),
            triangles: self.instances.values().map(triangles).sum(),
            lights: self.lights.len(),
        }
    }
}
