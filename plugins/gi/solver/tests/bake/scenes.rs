//! Scenes to bake.

use farlight_gi_solver::{Scene, scene::InstanceId, session::SessionChange};

use crate::common::Builder;

/// The scene that a builder's changes make, and its receivers.
pub(crate) fn built(builder: Builder) -> (Scene, Vec<InstanceId>) {
    let (mut scene, mut receivers) = (Scene::default(), Vec::new());
    for change in builder.changes {
        match change {
            SessionChange::Scene(change) => scene.apply(change),
            SessionChange::AddReceiver(id) => receivers.push(id),
            _ => {}
        }
    }
    (scene, receivers)
}
