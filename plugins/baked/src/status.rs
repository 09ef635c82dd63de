//! How baked lighting is doing, for games to show and tests to read.

use std::sync::Arc;

use bevy::prelude::*;
use farlight_core::LeftOut;

/// How baked lighting is doing.
#[derive(Resource, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone)]
pub struct BakedStatus {
    /// One for each entity with a [`BakedLighting`](crate::BakedLighting), in the order of entities.
    pub roots: Vec<BakedRoot>,
    /// Who blends scenarios.
    pub blending: Blending,
    /// Textures that were blended since the start; it stands still while weights do.
    pub blends: u64,
}

impl BakedStatus {
    /// That of one root.
    #[must_use]
    pub fn root(&self, entity: Entity) -> Option<&BakedRoot> {
        self.roots.iter().find(|root| root.entity == entity)
    }

    /// Whether everything that can be lit is.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        !self.roots.is_empty() && self.roots.iter().all(|root| root.state == BakedState::Lit)
    }

    /// Meshes that have a lightmap.
    #[must_use]
    pub fn receivers(&self) -> usize {
        self.roots.iter().map(|root| root.receivers).sum()
    }

    /// Bytes of the GPU's memory that textures take, those that roots share counted for each.
    #[must_use]
    pub fn texture_bytes(&self) -> u64 {
        self.roots.iter().map(|root| root.texture_bytes).sum()
    }
}

/// One lit scene.
#[derive(Clone, Debug, PartialEq, Reflect)]
#[reflect(Debug, Clone)]
pub struct BakedRoot {
    /// The entity with the [`BakedLighting`](crate::BakedLighting).
    pub entity: Entity,
    /// What happens with it.
    pub state: BakedState,
    /// Meshes that have a lightmap.
    pub receivers: usize,
    /// Boxes of probes.
    pub volumes: usize,
    /// Lights that the bake knows: those of the file and those that were added.
    pub lights: usize,
    /// What isn't lit as the manifest says, and why; the entity is the root where there is no other.
    pub left_out: Vec<LeftOut>,
    /// The manifest's scenarios and their weights in force.
    pub scenarios: Vec<(String, f32)>,
    /// Scenarios and weights that can't be as asked.
    pub problems: Vec<String>,
    /// Bytes of the GPU's memory that its textures take.
    pub texture_bytes: u64,
    /// Whether the bake came to its end; if not, the light is right but noisier.
    pub complete: bool,
}

impl BakedRoot {
    pub(crate) fn new(entity: Entity) -> Self {
        Self {
            entity,
            state: BakedState::default(),
            receivers: 0,
            volumes: 0,
            lights: 0,
            left_out: Vec::new(),
            scenarios: Vec::new(),
            problems: Vec::new(),
            texture_bytes: 0,
            complete: true,
        }
    }
}

/// What happens with a root.
#[derive(Clone, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Default, Debug, Clone)]
pub enum BakedState {
    /// Manifest, textures or scene are on their way.
    #[default]
    Loading,
    /// What can be lit is.
    Lit,
    /// Nothing can be.
    Failed {
        /// Why.
        reason: Arc<str>,
    },
}

/// Who blends scenarios.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Default, Debug, Clone)]
pub enum Blending {
    /// Nobody: nothing is drawn.
    #[default]
    Nobody,
    /// The GPU.
    Gpu,
    /// The CPU, since the GPU has no compute shaders or too small limits (WebGL2): slower by far, so
    /// change weights rarely.
    Cpu,
}
