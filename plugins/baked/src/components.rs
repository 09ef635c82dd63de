//! What a game puts on its entities.

use bevy::prelude::*;

use crate::{BakedManifest, ScenarioWeights};

/// Lights everything below an entity by what `farlight bake` made.
///
/// Put it on the root of the lit scene, the entity with the `WorldAssetRoot` of the .glb file that the
/// bake wrote, before or after it is loaded ([`BakedScene`] does both). Lightmaps, probe volumes and
/// lights come when scene and manifest are there, follow the root, come again when the scene is
/// spawned again or a file changes, and go with this component. Several roots may share a manifest,
/// each with scenarios of its own.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct BakedLighting {
    /// What was baked: a file `NAME.baked.ron`.
    pub manifest: Handle<BakedManifest>,
    /// How much of each scenario is shown.
    pub scenarios: ScenarioWeights,
    /// Whether lightmaps are filtered by cubic splines: smoother where texels are large on screen,
    /// dearer, and it may leak across the edges of charts.
    pub bicubic: bool,
    /// Whether a manifest with a single scenario may be dimmed at any moment without a frame in which
    /// the lightmaps are missing; it costs textures of 8 bytes a texel. Manifests with several
    /// scenarios can always be.
    pub dimmable: bool,
    /// Whether backs of single-sided lit meshes cast shadows in the lights of the bake, as they do in the
    /// bake itself. Without it Bevy's lights shine through such walls from behind. It costs a twin of
    /// each such mesh in shadow maps, on the render layer [`SHADOW_LAYER`](crate::SHADOW_LAYER).
    /// Default: true.
    pub solid_backs: bool,
}

impl Default for BakedLighting {
    fn default() -> Self {
        Self {
            manifest: Handle::default(),
            scenarios: ScenarioWeights::default(),
            bicubic: false,
            dimmable: false,
            solid_backs: true,
        }
    }
}

impl BakedLighting {
    /// What a manifest says, its first scenario.
    #[must_use]
    pub fn new(manifest: Handle<BakedManifest>) -> Self {
        Self { manifest, ..Self::default() }
    }
}

/// Spawns a lit scene: loads a manifest, spawns the scene that it names below this entity, and lights
/// it by the [`BakedLighting`] that it adds.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[require(Transform, Visibility)]
pub struct BakedScene(
    /// The manifest's path among the assets: `rooms/office.baked.ron`.
    pub String,
);

/// On what this plugin spawns below a root: probe volumes, the lights that a bake added, and twins of
/// meshes that cast the shadows of their backs.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
pub struct BakedPart;
