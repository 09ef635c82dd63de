//! Scene changes in, lighting updates out: what a background thread or a server runs.
//!
//! A [`Session`] owns a scene and keeps its lighting solved. It is driven from outside: [`apply`]
//! hands over changes, [`step`] does one bounded piece of work and returns what became better.
//! It never sleeps, reads no clock for its results and starts no thread of its own besides rayon's.
//!
//! [`apply`]: Session::apply
//! [`step`]: Session::step

mod place;
mod publish;
mod run;
mod solve;
mod texels;

use std::sync::Arc;

use glam::{Affine3A, UVec3, Vec3};

use crate::{
    atlas::{PageId, TexelRect},
    scene::{InstanceId, SceneChange},
    sh::ShRgb,
};

pub(crate) use place::Places;
pub use run::Session;
pub use solve::{Solve, panic_message};
pub use texels::{TexelPoint, reference};

/// Names a state of the scene; chosen by whoever sends changes, growing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SnapshotId(pub u64);

/// How lighting is solved.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionSettings {
    /// Edge of a square lightmap page in texels (power of two, 16..=4096).
    pub page_size: u32,
    /// Most pages; when they are full the texel density is lowered so that everything fits.
    pub max_pages: u32,
    /// Lightmap texels a metre that are aimed for.
    pub texels_per_metre: f32,
    /// Gather rays a texel that are kept for answers while light moves (64..=8192).
    pub rays_per_texel: u32,
    /// Gather rays a probe.
    pub rays_per_probe: u32,
    /// Most memory for kept rays in bytes; `rays_per_texel` is lowered to stay below.
    pub ray_memory: usize,
    /// Reflections of light that are followed (1 = one bounce); from 6 on, all are.
    pub bounces: u32,
    /// Paths a texel after which a still scene counts as converged and work stops.
    pub converged_paths: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Threads that work at the same time; 0 is one fewer than there are cores, so that whoever draws
    /// keeps one. Results do not depend on it.
    pub threads: usize,
}

impl Default for SessionSettings {
    fn default() -> Self {
        Self {
            page_size: 512,
            max_pages: 4,
            texels_per_metre: 8.0,
            rays_per_texel: 1024,
            rays_per_probe: 1024,
            ray_memory: 256 << 20,
            bounces: 8,
            converged_paths: 4096,
            seed: 1,
            threads: 0,
        }
    }
}

/// A box of probes on a regular grid. Probe `(x, y, z)` sits at the centre of its cell:
/// `transform * ((xyz + 0.5) / resolution - 0.5)`, as in Bevy's irradiance volumes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeGrid {
    /// From the unit cube (-0.5..0.5) to the world.
    pub transform: Affine3A,
    /// Probes along x, y, z.
    pub resolution: UVec3,
}

/// Identifies a probe grid; chosen by the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GridId(pub u64);

/// What can be asked of a session.
#[derive(Clone, Debug)]
pub enum SessionChange {
    /// The scene changed.
    Scene(SceneChange),
    /// Solve lightmap texels for this instance (its mesh needs a second UV set).
    AddReceiver(InstanceId),
    /// Its lightmap is no longer needed; the rectangle is freed. The instance stays in the scene.
    RemoveReceiver(InstanceId),
    /// Adds or replaces a probe grid.
    SetGrid(GridId, ProbeGrid),
    /// Forgets a probe grid.
    RemoveGrid(GridId),
}

/// Where an instance's second UV square lies in the atlas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The instance.
    pub instance: InstanceId,
    /// The page.
    pub page: PageId,
    /// The texels that its UV square 0..1 covers, gutters included.
    pub rect: TexelRect,
}

/// Texels of one rectangle of a page, dilated, ready to be written into a texture.
#[derive(Clone, Debug)]
pub struct Tile {
    /// The page.
    pub page: PageId,
    /// Where in the page.
    pub rect: TexelRect,
    /// `rect.width * rect.height` values E / π (indirect, and the sky's direct part unless the scene
    /// leaves it out: [`DirectSky`](crate::scene::DirectSky)), rows from the top.
    pub texels: Vec<Vec3>,
}

/// All probes of a grid, x fastest, then y, then z.
#[derive(Clone, Debug)]
pub struct GridUpdate {
    /// The grid.
    pub grid: GridId,
    /// Its resolution.
    pub resolution: UVec3,
    /// Incident radiance in SH (indirect, and the sky's direct part unless the scene leaves it out).
    /// Probes inside walls hold what their valid neighbours hold.
    pub probes: Vec<ShRgb>,
}

/// How good an update is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quality {
    /// Estimated median relative error of the lit texels' irradiance (1 = 100 %).
    pub relative_error: f32,
    /// Rays or paths a texel behind it.
    pub rays_per_texel: u32,
    /// Whether nothing better will come until the scene changes.
    pub converged: bool,
}

/// What became better.
#[derive(Clone, Debug, Default)]
pub struct LightingUpdate {
    /// The newest snapshot whose changes it shows.
    pub snapshot: SnapshotId,
    /// Placements that are new or moved since the last update; they come with their tiles.
    pub placements: Vec<Placement>,
    /// Receivers that were refused, and why.
    pub refused: Vec<(InstanceId, Arc<str>)>,
    /// Texels that changed.
    pub tiles: Vec<Tile>,
    /// Probe grids that changed.
    pub grids: Vec<GridUpdate>,
    /// How good it is.
    pub quality: Quality,
}
