//! Sets of the file, moved and scaled so that their charts fill the square.

use farlight_gi_solver::{
    scene::Mesh,
    unwrap::{Unwrapped, charts},
};
use glam::{UVec2, Vec2};

/// Where a set lies in its square.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) low: Vec2,
    pub(super) high: Vec2,
}

impl Bounds {
    /// Of the vertices that triangles use.
    pub(super) fn of(mesh: &Mesh) -> Self {
        let used = mesh.triangles.as_flattened().iter().map(|&i| mesh.uv1[i as usize]);
        let empty = Self { low: Vec2::INFINITY, high: Vec2::NEG_INFINITY };
        used.fold(empty, |b, uv| Self { low: b.low.min(uv), high: b.high.max(uv) })
    }
}

/// The rectangle that a set needs: `edge` texels an edge of the file's square, `margin` texels at each
/// border, at most `max` texels an edge.
pub(super) struct Crop {
    pub(super) size: UVec2,
    low: Vec2,
    /// Texels an edge of the file's square.
    pub(super) edge: f32,
    margin: f32,
}

impl Crop {
    pub(super) fn new(bounds: &Bounds, edge: f32, margin: f32, max: u32) -> Self {
        let extent = bounds.high - bounds.low;
        let most = (max as f32 - 2.0 * margin).max(1.0);
        let edge = edge.min(most / extent.max_element().max(1e-9));
        // Not a texel more for a rounding error.
        let size = (extent * edge + 2.0 * margin - 1e-3).ceil().max(Vec2::ONE).as_uvec2();
        Self { size: size.min(UVec2::splat(max)), low: bounds.low, edge, margin }
    }

    fn place(&self, uv: Vec2) -> Vec2 {
        let size = self.size.as_vec2();
        // Half of what is left on each side would move texels for nothing: charts stay at the margin.
        (((uv - self.low) * self.edge + self.margin) / size).clamp(Vec2::ZERO, Vec2::ONE)
    }

    /// Whether the set is in its place: nothing moves by more than a quarter of a texel.
    pub(super) fn is_identity(&self, bounds: &Bounds) -> bool {
        let size = self.size.as_vec2();
        let moves = |uv: Vec2| ((self.place(uv) - uv) * size).abs().max_element();
        moves(bounds.low).max(moves(bounds.high)) < 0.25
    }

    /// The mesh's own vertices with the cropped set.
    pub(super) fn apply(&self, mesh: &Mesh) -> Unwrapped {
        unchanged(mesh, mesh.uv1.iter().map(|&uv| self.place(uv)).collect(), self.size)
    }
}

/// The mesh's own vertices with a set.
pub(super) fn unchanged(mesh: &Mesh, uv1: Vec<Vec2>, size: UVec2) -> Unwrapped {
    Unwrapped {
        source: (0..mesh.positions.len() as u32).collect(),
        triangles: mesh.triangles.clone(),
        uv1,
        charts: charts(mesh),
        size,
        gutter: f32::INFINITY,
        ..Default::default()
    }
}

/// A vertex a corner: what engines make of meshes without normals, whose faces are flat.
pub(super) fn split(unwrapped: &mut Unwrapped) {
    let corners: Vec<usize> =
        unwrapped.triangles.as_flattened().iter().map(|&i| i as usize).collect();
    unwrapped.source = corners.iter().map(|&i| unwrapped.source[i]).collect();
    unwrapped.uv1 = corners.iter().map(|&i| unwrapped.uv1[i]).collect();
    let triangles = unwrapped.triangles.len() as u32;
    unwrapped.triangles = (0..triangles).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
}

/// Whether a mesh's corners have a vertex each, in order.
pub(super) fn is_split(mesh: &Mesh) -> bool {
    mesh.triangles.as_flattened().iter().enumerate().all(|(i, &vertex)| i as u32 == vertex)
        && mesh.positions.len() == 3 * mesh.triangles.len()
}
