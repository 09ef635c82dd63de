//! From triangles to the tree.

use glam::{Vec3, Vec3A};

use super::{
    binary::{self, Bounds},
    collapse::Collapse,
    node::Tree,
    ray::FAR,
};

/// A triangle, or the part of one that lies in a box.
#[derive(Clone, Copy)]
pub(super) struct Reference {
    pub(super) bounds: Bounds,
    /// Index in the caller's list.
    pub(super) triangle: u32,
}

impl Reference {
    pub(super) fn centre(&self) -> Vec3A {
        (self.bounds.min + self.bounds.max) * 0.5
    }
}

/// Triangles after these are left out, so that indices of nodes and packs fit.
pub(super) const MOST: usize = 1 << 27;

/// Builds the tree.
pub(super) fn build(triangles: &[[Vec3; 3]]) -> Tree {
    let references: Vec<Reference> = triangles
        .iter()
        .enumerate()
        .take(MOST)
        .filter(|(_, corners)| usable(corners))
        .map(|(i, &[a, b, c])| Reference {
            bounds: Bounds { min: a.min(b).min(c).into(), max: a.max(b).max(c).into() },
            triangle: i as u32,
        })
        .collect();
    if references.is_empty() {
        return Tree::default();
    }
    let nodes = binary::build(triangles, references);
    Collapse::new(triangles, &nodes).run()
}

/// Whether a ray can hit it at all: finite, not absurdly far away, and not of zero area.
fn usable(corners: &[Vec3; 3]) -> bool {
    // A NaN fails the comparison.
    if !corners.iter().all(|p| p.abs().cmple(Vec3::splat(FAR)).all()) {
        return false;
    }
    // Differences of single-precision numbers and their products round alike in double precision,
    // so corners on a line give exactly zero.
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let normal = (b - a).cross(c - a);
    normal.x != 0.0 || normal.y != 0.0 || normal.z != 0.0
}
