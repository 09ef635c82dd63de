//! From triangles to the tree: a binary tree by obvhs, made eight wide.

use glam::Vec3;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
    splits::split_aabbs_preset,
    triangle::Triangle,
};

use super::{collapse::Collapse, node::Tree, ray::FAR};

/// Whether large triangles enter the tree in several parts.
const SPLIT: bool = false;
/// Share of the nodes that reinsertion looks at.
const REINSERTION: f32 = 0.2;

/// A part of a triangle: its box, and the triangle's index in the caller's list.
#[derive(Clone, Copy)]
pub(super) struct Reference {
    pub(super) min: [f32; 3],
    pub(super) max: [f32; 3],
    pub(super) triangle: u32,
}

/// Builds the tree.
pub(super) fn build(triangles: &[[Vec3; 3]]) -> Tree {
    let (references, boxes) = references(triangles);
    if references.is_empty() {
        return Tree::default();
    }
    let bvh = binary(&boxes);
    drop(boxes);
    Collapse::new(triangles, &references, &bvh).run()
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

/// Boxes of the usable triangles, large ones in several parts, and the same boxes for obvhs.
fn references(triangles: &[[Vec3; 3]]) -> (Vec<Reference>, Vec<Aabb>) {
    let convert = |p: Vec3| glam34::Vec3A::from_array(p.to_array());
    let mut source = Vec::with_capacity(triangles.len());
    let mut converted = Vec::with_capacity(triangles.len());
    for (i, corners) in triangles.iter().enumerate().take(u32::MAX as usize) {
        if usable(corners) {
            source.push(i as u32);
            let [v0, v1, v2] = corners.map(convert);
            converted.push(Triangle { v0, v1, v2 });
        }
    }
    let mut boxes: Vec<Aabb> =
        converted.iter().map(|t| Aabb::from_points(&[t.v0, t.v1, t.v2])).collect();
    let mut indices: Vec<u32> = (0..converted.len() as u32).collect();
    let mut largest = 0.0f32;
    let mut sum = 0.0;
    for b in &boxes {
        largest = largest.max(b.half_area());
        sum += f64::from(b.half_area());
    }
    if SPLIT {
        split_aabbs_preset(
            &mut boxes,
            &mut indices,
            &converted,
            (sum / converted.len().max(1) as f64) as f32,
            largest,
        );
    }
    let references = boxes
        .iter()
        .zip(&indices)
        .map(|(b, &i)| Reference {
            min: b.min.to_array(),
            max: b.max.to_array(),
            triangle: source[i as usize],
        })
        .collect();
    (references, boxes)
}

/// The binary tree: locally ordered clustering, then reinsertion. The index in a leaf is that of
/// the box.
fn binary(boxes: &[Aabb]) -> Bvh2 {
    let indices = (0..boxes.len() as u32).collect();
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::High,
        boxes,
        indices,
        SortPrecision::U64,
        2,
    );
    ReinsertionOptimizer::default().run(&mut bvh, REINSERTION, None);
    bvh
}
