//! Second UV sets: the solver's unwrapper behind a form that fits Bevy's meshes.

use bevy::math::Vec2;
use farlight_gi_solver::scene::Mesh;

/// What came of looking for a second UV set.
#[expect(dead_code, reason = "the unwrapper is not here yet")]
pub(crate) enum Uv1 {
    /// The mesh's own is fine.
    Usable,
    /// A new one; vertices are split at its seams.
    Made {
        /// For each new vertex the old one it is a copy of.
        source: Vec<u32>,
        /// One a new vertex.
        uv1: Vec<Vec2>,
        /// Three new vertices a triangle.
        triangles: Vec<[u32; 3]>,
    },
}

/// Checks the second UV set and makes one where it is missing, overlaps or tiles.
pub(crate) fn second_uv_set(mesh: &Mesh) -> Result<Uv1, String> {
    if mesh.uv1.is_empty() { Err("it has no second UV set".into()) } else { Ok(Uv1::Usable) }
}
