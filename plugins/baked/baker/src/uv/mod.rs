//! Which primitive gets which second UV set, and how many texels.
//!
//! A lightmap needs texels of even size on the surface, none of them used twice, with gutters
//! between charts. [`second_sets`] keeps a set of the file that is like that (cropped, so that the
//! charts of each primitive fill its own square 0..1) and makes one otherwise. [`apply`] puts the sets
//! into the scene that is solved, [`gltf::write`](crate::gltf::write()) into the file: both have the
//! same vertices in the same order, so that
//! `Fingerprint::of_uv(scene.meshes[id].uv1)` is that of the lit scene too.

use std::{collections::BTreeMap, sync::Arc};

use farlight_baked_format::Fingerprint;
use farlight_gi_solver::{
    import::ImportedScene,
    scene::{InstanceId, MeshId},
    unwrap::{UnwrapOptions, Unwrapped, ensure_uv1},
};
use glam::UVec2;
use thiserror::Error;

use crate::gltf::Source;

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
    /// That of the file, moved and scaled to fill the square; vertices may be fewer.
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

/// A primitive's second UV set, and the texels for it.
#[derive(Clone, Debug, PartialEq)]
pub struct SecondSet {
    /// The set.
    pub set: UvSet,
    /// Edges in texels of the rectangle that the square 0..1 should get, by instance of the mesh. Empty
    /// without a set.
    pub sizes: BTreeMap<InstanceId, UVec2>,
    /// Texels a metre in the largest instance.
    pub texels_per_metre: f32,
    /// Texels between charts in the smallest instance.
    pub gutter: f32,
}

/// Keeps what was unwrapped from one bake to the next.
pub trait UvCache: Sync {
    /// What was put for a key.
    fn get(&self, key: Fingerprint) -> Option<Vec<u8>>;
    /// Keeps bytes for a key; failing silently is fine.
    fn put(&self, key: Fingerprint, bytes: &[u8]);
}

/// Keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoCache;

impl UvCache for NoCache {
    fn get(&self, _key: Fingerprint) -> Option<Vec<u8>> {
        None
    }

    fn put(&self, _key: Fingerprint, _bytes: &[u8]) {}
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
    let _ = (source, cache);
    let total = imported.scene.meshes.len();
    let mut sets = BTreeMap::new();
    for (done, (&id, mesh)) in imported.scene.meshes.iter().enumerate() {
        if !progress(done, total) {
            return Err(Cancelled);
        }
        let texels = 64;
        let set = match ensure_uv1(mesh, &UnwrapOptions { texels, ..Default::default() }) {
            Ok(unwrapped) => UvSet::Made { unwrapped, why: String::new() },
            Err(error) => UvSet::None { reason: error.to_string() },
        };
        let instances = imported.scene.instances.iter();
        let sizes = instances
            .filter(|(_, instance)| instance.mesh == id)
            .map(|(&id, _)| (id, UVec2::splat(texels)))
            .collect();
        let texels_per_metre = options.texels_per_metre;
        sets.insert(id, SecondSet { set, sizes, texels_per_metre, gutter: 2.0 });
    }
    Ok(sets)
}

/// Puts second UV sets into the scene; meshes that get none lose theirs.
pub fn apply(imported: &mut ImportedScene, sets: &BTreeMap<MeshId, SecondSet>) {
    for (id, second) in sets {
        let Some(mesh) = imported.scene.meshes.get_mut(id) else { continue };
        match &second.set {
            UvSet::Kept => {}
            UvSet::Cropped { unwrapped } | UvSet::Made { unwrapped, .. } => {
                *mesh = Arc::new(unwrapped.apply(mesh));
            }
            UvSet::None { .. } => Arc::make_mut(mesh).uv1.clear(),
        }
    }
}
