//! The binary tree, from the root downwards, by the surface area heuristic.
//!
//! Objects are split between bins of their centres (Wald 2007, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies"). Where the two halves would overlap, a plane that cuts triangles
//! in two may be cheaper (Stich, Friedrich and Dietrich 2009, "Spatial Splits in Bounding Volume
//! Hierarchies"); how many more references this makes is bounded. Where neither helps, or the
//! tree has become too deep, the list is cut in the middle, so the time is bounded, too.

use glam::{Vec3, Vec3A};

use super::build::Reference;

/// Bins of an axis.
const BINS: usize = 16;
/// Spatial splits may make this many more references, as a share of the triangles.
const SPLIT_BUDGET: f32 = 0.2;
/// A spatial split is tried if the overlap's area is more than this share of the root's.
const SPLIT_OVERLAP: f32 = 1.0e-3;
/// From this depth on lists are cut in the middle.
const BALANCED_DEPTH: usize = 64;
/// Subtrees of more references are built in parallel.
const PARALLEL: usize = 4096;

/// A box that grows; aligned, for vector instructions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) min: Vec3A,
    pub(super) max: Vec3A,
}

impl Bounds {
    pub(super) const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    pub(super) fn add(&mut self, other: Self) {
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    fn add_point(&mut self, p: Vec3A) {
        self.min = self.min.min(p);
        self.max = self.max.max(p);
    }

    fn clipped(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Half the surface, 0 if empty.
    pub(super) fn area(&self) -> f32 {
        let d = (self.max - self.min).max(Vec3A::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }
}

/// A node of the binary tree.
#[derive(Clone, Copy)]
pub(super) struct BinaryNode {
    pub(super) bounds: Bounds,
    pub(super) content: Content,
}

/// What a binary node holds.
#[derive(Clone, Copy)]
pub(super) enum Content {
    /// Two nodes, at this index and the next.
    Children(u32),
    /// One triangle.
    Triangle(u32),
}

/// Builds the tree; the root comes first. `references` must not be empty.
pub(super) fn build(triangles: &[[Vec3; 3]], references: Vec<Reference>) -> Vec<BinaryNode> {
    let mut bounds = Bounds::EMPTY;
    references.iter().for_each(|r| bounds.add(r.bounds));
    let builder = Builder { triangles, least_overlap: bounds.area() * SPLIT_OVERLAP };
    let budget = (references.len() as f32 * SPLIT_BUDGET) as usize;
    let mut nodes = Vec::with_capacity(2 * references.len());
    nodes.push(BinaryNode { bounds, content: Content::Triangle(0) });
    builder.subtree(0, references, budget, 0, &mut nodes);
    nodes
}

struct Builder<'a> {
    triangles: &'a [[Vec3; 3]],
    least_overlap: f32,
}

/// A way to divide a node.
struct Split {
    cost: f32,
    axis: usize,
    /// Bins below this one go left.
    bin: usize,
    left: Bounds,
    right: Bounds,
}

impl Builder<'_> {
    /// Fills the subtree under `nodes[at]`, whose bounds are known.
    fn subtree(
        &self,
        at: usize,
        references: Vec<Reference>,
        budget: usize,
        depth: usize,
        nodes: &mut Vec<BinaryNode>,
    ) {
        if let [reference] = references[..] {
            nodes[at].content = Content::Triangle(reference.triangle);
            return;
        }
        let bounds = nodes[at].bounds;
        let total = references.len();
        let (left, right) = self.divide(&bounds, references, budget, depth);
        // What is left of the budget is shared by number.
        let budget = budget.saturating_sub(left.len() + right.len() - total);
        let to_left =
            (budget as u64 * left.len() as u64 / (left.len() + right.len()) as u64) as usize;
        let first = nodes.len();
        nodes[at].content = Content::Children(first as u32);
        for list in [&left, &right] {
            let mut bounds = Bounds::EMPTY;
            list.iter().for_each(|r| bounds.add(r.bounds));
            nodes.push(BinaryNode { bounds, content: Content::Triangle(0) });
        }
        let depth = depth + 1;
        if left.len().min(right.len()) > PARALLEL {
            let root = nodes[first + 1];
            let (_, other) = rayon::join(
                || self.subtree(first, left, to_left, depth, nodes),
                || {
                    let mut other = vec![root];
                    self.subtree(0, right, budget - to_left, depth, &mut other);
                    other
                },
            );
            // Its root is in place already; the rest moves as a block.
            let shift = nodes.len() as u32 - 1;
            let moved = |mut node: BinaryNode| {
                if let Content::Children(c) = &mut node.content {
                    *c += shift;
                }
                node
            };
            nodes[first + 1] = moved(other[0]);
            nodes.extend(other[1..].iter().map(|&n| moved(n)));
        } else {
            self.subtree(first, left, to_left, depth, nodes);
            self.subtree(first + 1, right, budget - to_left, depth, nodes);
        }
    }

    /// Two lists, neither of them empty. Not inlined, so that its arrays aren't on the stack while
    /// `subtree` recurses.
    #[inline(never)]
    fn divide(
        &self,
        bounds: &Bounds,
        mut references: Vec<Reference>,
        budget: usize,
        depth: usize,
    ) -> (Vec<Reference>, Vec<Reference>) {
        if depth < BALANCED_DEPTH && references.len() > 2 {
            let mut centres = Bounds::EMPTY;
            references.iter().for_each(|r| centres.add_point(r.centre()));
            let object = object_split(&centres, &references);
            let overlap = object.as_ref().map_or(f32::INFINITY, |s| s.left.clipped(s.right).area());
            if budget > 0 && overlap > self.least_overlap {
                let whole = bounds.area() * references.len() as f32;
                let least = object.as_ref().map_or(whole, |s| s.cost.min(whole));
                if let Some(split) = self.spatial_split(bounds, &references, budget, least)
                    && let Some(lists) = self.cut(bounds, &split, &references, budget)
                {
                    return lists;
                }
            }
            if let Some(split) = object {
                let bins = Bins::new(&centres, references.len());
                let (mut left, mut right) = (Vec::new(), Vec::new());
                for r in references {
                    let to_left = bins.of(r.centre(), split.axis) < split.bin;
                    if to_left { left.push(r) } else { right.push(r) }
                }
                return (left, right);
            }
        }
        let right = references.split_off(references.len() / 2);
        (references, right)
    }

    /// The cheapest plane that cuts, if it is cheaper than `least`.
    fn spatial_split(
        &self,
        bounds: &Bounds,
        references: &[Reference],
        budget: usize,
        least: f32,
    ) -> Option<Split> {
        let bins = Bins::new(bounds, references.len());
        let mut best: Option<Split> = None;
        for axis in 0..3 {
            if bins.scale[axis] == 0.0 {
                continue;
            }
            let mut enter = [0u32; BINS];
            let mut leave = [0u32; BINS];
            for reference in references {
                enter[bins.of(reference.bounds.min, axis)] += 1;
                leave[bins.of(reference.bounds.max, axis)] += 1;
            }
            // No need to look closer if every plane would cut too many.
            let mut cut = 0;
            let affordable = (1..bins.count).any(|bin| {
                cut += enter[bin - 1] as usize;
                cut -= leave[bin - 1] as usize;
                cut <= budget
            });
            if !affordable {
                continue;
            }
            let mut boxes = [Bounds::EMPTY; BINS];
            for reference in references {
                let first = bins.of(reference.bounds.min, axis);
                let last = bins.of(reference.bounds.max, axis);
                let mut rest = *reference;
                for (bounds, bin) in boxes[first..last].iter_mut().zip(first + 1..) {
                    let (left, right) = self.clip(&rest, axis, bins.plane(axis, bin));
                    bounds.add(left);
                    rest.bounds = right;
                }
                boxes[last].add(rest.bounds);
            }
            let n = bins.count;
            sweep(axis, &boxes[..n], &enter[..n], &leave[..n], &mut best);
        }
        best.filter(|s| s.cost < least)
    }

    /// Divides the references at a plane. A reference that straddles it goes whole to one side
    /// where this is cheaper. Nothing if the plane doesn't divide, or only with too many pieces.
    fn cut(
        &self,
        bounds: &Bounds,
        split: &Split,
        references: &[Reference],
        budget: usize,
    ) -> Option<(Vec<Reference>, Vec<Reference>)> {
        let Split { axis, bin, .. } = *split;
        let plane = Bins::new(bounds, references.len()).plane(axis, bin);
        let (mut left, mut right, mut both) = (Vec::new(), Vec::new(), Vec::new());
        let (mut left_bounds, mut right_bounds) = (Bounds::EMPTY, Bounds::EMPTY);
        for &r in references {
            if r.bounds.max[axis] <= plane {
                left_bounds.add(r.bounds);
                left.push(r);
            } else if r.bounds.min[axis] >= plane {
                right_bounds.add(r.bounds);
                right.push(r);
            } else {
                both.push(r);
            }
        }
        // What it would be with all of them cut.
        let pieces: Vec<_> = both.iter().map(|r| self.clip(r, axis, plane)).collect();
        for (l, r) in &pieces {
            left_bounds.add(*l);
            right_bounds.add(*r);
        }
        let mut counts = [left.len() + both.len(), right.len() + both.len()].map(|n| n as f32);
        for (r, (l_piece, r_piece)) in both.into_iter().zip(pieces) {
            let [nl, nr] = counts;
            let (al, ar) = (left_bounds.area(), right_bounds.area());
            let mut left_whole = left_bounds;
            left_whole.add(r.bounds);
            let mut right_whole = right_bounds;
            right_whole.add(r.bounds);
            let cost_cut = al * nl + ar * nr;
            let cost_left = left_whole.area() * nl + ar * (nr - 1.0);
            let cost_right = al * (nl - 1.0) + right_whole.area() * nr;
            if l_piece.is_empty() || cost_right < cost_cut.min(cost_left) && !r_piece.is_empty() {
                right.push(r);
                right_bounds = right_whole;
                counts[0] -= 1.0;
            } else if r_piece.is_empty() || cost_left < cost_cut {
                left.push(r);
                left_bounds = left_whole;
                counts[1] -= 1.0;
            } else {
                left.push(Reference { bounds: l_piece, ..r });
                right.push(Reference { bounds: r_piece, ..r });
            }
        }
        let more = left.len() + right.len() - references.len();
        let divides = left.len() < references.len() && right.len() < references.len();
        (divides && more <= budget && !left.is_empty() && !right.is_empty())
            .then_some((left, right))
    }

    /// Boxes of the parts of a reference on the two sides of a plane.
    fn clip(&self, reference: &Reference, axis: usize, plane: f32) -> (Bounds, Bounds) {
        let (mut left, mut right) = (Bounds::EMPTY, Bounds::EMPTY);
        let corners = self.triangles[reference.triangle as usize].map(Vec3A::from);
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let (da, db) = (a[axis], b[axis]);
            if da <= plane {
                left.add_point(a);
            }
            if da >= plane {
                right.add_point(a);
            }
            if (da < plane && db > plane) || (da > plane && db < plane) {
                let k = ((plane - da) / (db - da)).clamp(0.0, 1.0);
                let mut p = a + k * (b - a);
                p[axis] = plane;
                left.add_point(p);
                right.add_point(p);
            }
        }
        left.max[axis] = left.max[axis].min(plane);
        right.min[axis] = right.min[axis].max(plane);
        (left.clipped(reference.bounds), right.clipped(reference.bounds))
    }
}

/// Equal intervals of a box's axes.
struct Bins {
    count: usize,
    min: Vec3A,
    size: Vec3A,
    /// Bins a unit; 0 where the box is flat.
    scale: Vec3A,
}

impl Bins {
    /// Few bins for few references.
    fn new(bounds: &Bounds, references: usize) -> Self {
        let count = references.clamp(4, BINS);
        let size = bounds.max - bounds.min;
        let scale = size.map(|s| if s > 0.0 { (count as f32 / s).min(f32::MAX) } else { 0.0 });
        Self { count, min: bounds.min, size, scale }
    }

    fn of(&self, p: Vec3A, axis: usize) -> usize {
        (((p[axis] - self.min[axis]) * self.scale[axis]) as usize).min(self.count - 1)
    }

    /// Where a bin begins.
    fn plane(&self, axis: usize, bin: usize) -> f32 {
        self.min[axis] + self.size[axis] * (bin as f32 / self.count as f32)
    }
}

/// The cheapest division by centres.
fn object_split(centres: &Bounds, references: &[Reference]) -> Option<Split> {
    let bins = Bins::new(centres, references.len());
    let mut boxes = [[Bounds::EMPTY; BINS]; 3];
    let mut counts = [[0u32; BINS]; 3];
    for reference in references {
        let centre = reference.centre();
        for axis in 0..3 {
            let bin = bins.of(centre, axis);
            boxes[axis][bin].add(reference.bounds);
            counts[axis][bin] += 1;
        }
    }
    let mut best = None;
    for axis in 0..3 {
        if bins.scale[axis] > 0.0 {
            let (boxes, counts) = (&boxes[axis][..bins.count], &counts[axis][..bins.count]);
            sweep(axis, boxes, counts, counts, &mut best);
        }
    }
    best
}

/// Takes the axis's cheapest division if it is cheaper than `best`.
fn sweep(axis: usize, boxes: &[Bounds], enter: &[u32], leave: &[u32], best: &mut Option<Split>) {
    let mut after = [(Bounds::EMPTY, 0); BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for i in (1..boxes.len()).rev() {
        bounds.add(boxes[i]);
        count += leave[i];
        after[i] = (bounds, count);
    }
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for bin in 1..boxes.len() {
        bounds.add(boxes[bin - 1]);
        count += enter[bin - 1];
        let (right, right_count) = after[bin];
        if count == 0 || right_count == 0 {
            continue;
        }
        let cost = bounds.area() * count as f32 + right.area() * right_count as f32;
        if best.as_ref().is_none_or(|b| cost < b.cost) {
            *best = Some(Split { cost, axis, bin, left: bounds, right });
        }
    }
}
