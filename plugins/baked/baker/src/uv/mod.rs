//! Which primitive gets which second UV set, and how many texels.
//!
//! A lightmap needs texels of even size on the surface, none of them used twice, with gutters
//! between charts. [`second_sets`] keeps a set of the file that is like that (cropped, so that the
//! charts of each primitive fill its own square 0..1) and makes one otherwise. [`apply`] puts the sets
//! into the scene that is solved, [`gltf::write`](crate::gltf::write()) into the file: both have the
//! same vertices in the same order, so that `Fingerprint::of_uv(scene.meshes[id].uv1)` is that of
//! the primitive in the lit scene too, as the engine loads it.
//!
//! Charts stay half a gutter away from the border of their square: rectangles may stand side by side
//! in a page. The exception are sets that must not be changed because a texture is placed by them.
//!
//! A mesh has one set for all of its instances, mirrored ones too: a mirror turns triangles and
//! normals round, not their UVs.

mod cache;
mod crop;
mod decide;
mod facts;
mod size;

use std::{
    collections::BTreeMap,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};

use farlight_gi_solver::{
    import::{ImportedScene, split_id},
    scene::{InstanceId, MeshId},
    unwrap::Unwrapped,
};
use glam::UVec2;
use rayon::prelude::*;
use thiserror::Error;

pub use cache::{NoCache, UvCache};
pub use size::density_for;

use crate::gltf::Source;
use facts::Facts;

/// How many texels primitives get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvOptions {
    /// Texels a metre.
    pub texels_per_metre: f32,
    /// Texels between charts, and twice as many as between charts and the border of the square:
    /// bilinear lookups need 2, each mip level doubles that.
    pub padding: u32,
    /// Longest edge of a primitive's rectangle in texels; primitives that need more get fewer texels a
    /// metre.
    pub max_texels: u32,
}

impl Default for UvOptions {
    fn default() -> Self {
        Self { texels_per_metre: 16.0, padding: 2, max_texels: 1024 }
    }
}

/// A primitive's second UV set.
#[derive(Clone, Debug, PartialEq)]
pub enum UvSet {
    /// That of the file, with the vertices of the file.
    Kept,
    /// That of the file, moved and scaled to fill the square; vertices may be fewer, or more where the
    /// engine would split them.
    Cropped {
        /// Vertices and set.
        unwrapped: Unwrapped,
    },
    /// A new one.
    Made {
        /// Vertices and set.
        unwrapped: Unwrapped,
        /// Why that of the file was not kept.
        why: String,
    },
    /// None: the primitive gets no lightmap.
    None {
        /// Why.
        reason: String,
    },
}

impl UvSet {
    /// Vertices and set, if they are not those of the file.
    #[must_use]
    pub fn unwrapped(&self) -> Option<&Unwrapped> {
        match self {
            Self::Cropped { unwrapped } | Self::Made { unwrapped, .. } => Some(unwrapped),
            Self::Kept | Self::None { .. } => None,
        }
    }
}

/// A primitive's second UV set, and the texels for it.
#[derive(Clone, Debug, PartialEq)]
pub struct SecondSet {
    /// The set.
    pub set: UvSet,
    /// [`ImportedScene::file_vertices`] of the mesh: `Unwrapped::source` counts these.
    pub vertices: Option<Arc<[u32]>>,
    /// Edges in texels of the rectangle that the square 0..1 should get, by instance of the mesh: in
    /// proportion to their sizes, but never less than half of the largest. Empty without a set.
    pub sizes: BTreeMap<InstanceId, UVec2>,
    /// Texels a metre in the largest instance (the median over its surface).
    pub texels_per_metre: f32,
    /// Smallest distance in texels between two charts in the smallest instance; at most the padding.
    pub gutter: f32,
}

/// The caller asked to stop.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("cancelled")]
pub struct Cancelled;

/// Decides for each mesh of a scene what its second UV set is. `imported` is `source.scene(..)`, in
/// metres. `progress` is told the number of meshes that are done, of how many; it is asked often, from
/// any thread, and stops the work by returning false.
///
/// # Errors
/// [`Cancelled`] after `progress` returned false.
pub fn second_sets(
    imported: &ImportedScene,
    source: &Source,
    options: &UvOptions,
    cache: &dyn UvCache,
    progress: &(dyn Fn(usize, usize) -> bool + Sync),
) -> Result<BTreeMap<MeshId, SecondSet>, Cancelled> {
    let total = imported.scene.meshes.len();
    let (done, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    let go_on = || {
        if !stopped.load(Ordering::Relaxed) && !progress(done.load(Ordering::Relaxed), total) {
            stopped.store(true, Ordering::Relaxed);
        }
        !stopped.load(Ordering::Relaxed)
    };
    let mut instances: BTreeMap<MeshId, Vec<InstanceId>> = BTreeMap::new();
    for (&id, instance) in &imported.scene.instances {
        instances.entry(instance.mesh).or_default().push(id);
    }
    let skinned = facts::skinned_meshes(source);
    // Largest first: the last one decides how long all take.
    let mut order: Vec<_> = imported.scene.meshes.iter().collect();
    order.sort_by_key(|(_, mesh)| std::cmp::Reverse(mesh.triangles.len()));
    let sets: Vec<_> = order
        .into_par_iter()
        .map(|(&id, mesh)| {
            let facts = Facts {
                mesh,
                vertices: imported.file_vertices.get(&id),
                instances: instances
                    .get(&id)
                    .into_iter()
                    .flatten()
                    .filter_map(|id| Some((*id, imported.scene.instances.get(id)?.transform)))
                    .collect(),
                fixed: facts::textures_use_second_set(source, id),
                floats: facts::second_set_is_float(source, id),
                skinned: skinned.contains(&(split_id(id.0)[0] as usize)),
            };
            let set = go_on().then(|| decide::decide(&facts, options, cache, &go_on));
            done.fetch_add(1, Ordering::Relaxed);
            (id, set.flatten())
        })
        .collect();
    let _ = go_on();
    let sets: Option<BTreeMap<_, _>> = sets.into_iter().map(|(id, set)| Some((id, set?))).collect();
    sets.filter(|_| !stopped.load(Ordering::Relaxed)).ok_or(Cancelled)
}

/// Puts second UV sets into the scene; meshes that get none lose theirs.
pub fn apply(imported: &mut ImportedScene, sets: &BTreeMap<MeshId, SecondSet>) {
    for (id, second) in sets {
        let Some(mesh) = imported.scene.meshes.get_mut(id) else { continue };
        match &second.set {
            UvSet::Kept => {}
            UvSet::Cropped { unwrapped } | UvSet::Made { unwrapped, .. } => {
                *mesh = Arc::new(unwrapped.apply(mesh));
                imported.file_vertices.remove(id);
            }
            UvSet::None { .. } => Arc::make_mut(mesh).uv1.clear(),
        }
    }
}
