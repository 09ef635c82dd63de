//! Closest-hit and any-hit rays against a fixed set of triangles.
//!
//! **Tree.** A binary tree is built from the root by the surface area heuristic, with spatial
//! splits (Stich, Friedrich and Dietrich 2009, "Spatial Splits in Bounding Volume Hierarchies"),
//! and collapsed to eight children a node by dynamic programming (Ylitie, Karras and Laine 2017,
//! "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.1). Leaves
//! hold packs of four triangles. Nodes and packs are structures of arrays, so that one vector
//! instruction serves eight boxes or four triangles, as in Wald, Benthin and Boulos 2008, "Getting
//! Rid of Packets". The builder bounds the depth, hence the traversal stack has a fixed size.
//!
//! **Boxes.** All eight are tested at once. Rounding never loses one: boxes are grown when the
//! tree is built, and the ray's constants by an amount for its origin, so the test itself costs no
//! more than a careless one (compare Ize 2013, "Robust BVH Ray Traversal", JCGT 2(2), who pads the
//! result of each test). Each node stores the order of its children for the eight octants of
//! directions, which replaces sorting by distance (and visits within 1 % as many nodes); what is met
//! is compacted in that order onto the stack without a branch, and the nearest is known before the
//! stack is written. Any-hit rays need no order: they begin with large boxes and leaves.
//!
//! **Triangles.** Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection", JCGT 2(1):
//! corners are translated and sheared so that the ray becomes an axis, alike for every triangle
//! that shares the corner; two-dimensional edge functions then decide. They aren't fused, because a
//! product of floats rounds monotonically: the sign of a difference of two rounded products is
//! right or zero, never wrong. Zero counts as inside for both neighbours, so no ray passes between
//! two triangles that share an edge, nor at a corner; where all three functions vanish, double
//! precision decides (in which the products are exact). The distance of the hit that remains is
//! that of the triangle's plane, in double precision: the one from the edge functions is as exact
//! across the plane, but off by a thousand times more along a ray that grazes it.
//!
//! **Processors.** One traversal, two kernels: AVX2 with FMA, and plain arrays for everything else;
//! which one is found out once. Both give the same hits to the last bit. (AVX-512's registers and
//! masks were worth 3 %; sorting incoherent rays costs more than the 20 % it gains.)
//!
//! **Limits.** Coordinates up to 1e12; triangles beyond, with a NaN, or with no area are left out.
//! Which triangle comes first is decided to a few 1e-7 of the larger of the triangle's and the
//! origin's coordinates, across the triangles; the weights are as exact; the distance is rounded
//! once. Memory: about 75 bytes a triangle, at most 500
//! (every leaf a single triangle after the most splits); while building, up to 300 more. Triangles
//! after the first 2^27 are left out.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod binary;
mod build;
mod collapse;
mod node;
mod portable;
mod ray;
#[cfg(test)]
mod tests;
mod traverse;
mod triangle;

use glam::Vec3;
use rayon::prelude::*;

use node::Tree;

/// A ray segment. The direction need not be of unit length; `t` counts in its lengths.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Ray {
    /// Where it starts, in metres; within 1e12, else nothing is hit.
    pub origin: Vec3,
    /// Hits before this are ignored; a negative value counts as 0.
    pub t_min: f32,
    /// Where it goes. Zero or not finite: nothing is hit.
    pub direction: Vec3,
    /// Hits after this are ignored.
    pub t_max: f32,
}

impl Ray {
    /// A ray from `origin` to infinity.
    #[must_use]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
    }
}

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Barycentric weight of the triangle's second corner.
    pub u: f32,
    /// Barycentric weight of the triangle's third corner.
    pub v: f32,
    /// Index of the triangle, or [`Hit::MISS`].
    pub triangle: u32,
}

impl Hit {
    /// The triangle index of a ray that hit nothing.
    pub const MISS: u32 = u32::MAX;
    /// No hit.
    pub const NONE: Self = Self { t: f32::INFINITY, u: 0.0, v: 0.0, triangle: Self::MISS };

    /// Whether something was hit.
    #[must_use]
    pub fn is_hit(&self) -> bool {
        self.triangle != Self::MISS
    }
}

/// Answers ray queries against a fixed set of triangles.
pub struct Tracer {
    tree: Tree,
    instructions: Instructions,
}

/// What the processor offers, found out once.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Instructions {
    #[cfg(target_arch = "x86_64")]
    Avx2,
    Portable,
}

impl Instructions {
    /// What this processor can run, best first.
    fn available() -> Vec<Self> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        if avx2::available() {
            all.push(Self::Avx2);
        }
        all.push(Self::Portable);
        all
    }
}

impl Tracer {
    /// Builds the acceleration structure, on all threads; the result doesn't depend on their number.
    /// Takes 1 to 2 microseconds of a processor core a triangle. Triangles that are not finite, have
    /// no area, or lie beyond 1e12 are never hit. The index in a [`Hit`] is that of `triangles`.
    #[must_use]
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        Self { tree: build::build(triangles), instructions: Instructions::available()[0] }
    }

    /// Bytes of the acceleration structure.
    #[must_use]
    pub fn memory(&self) -> usize {
        self.tree.memory()
    }

    /// The closest hit of one ray.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Hit {
        match self.instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Instructions::available` has asked the processor.
            Instructions::Avx2 => unsafe { avx2::closest(&self.tree, ray) },
            Instructions::Portable => portable::closest(&self.tree, ray),
        }
    }

    /// Whether anything lies on the ray's segment.
    #[must_use]
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        match self.instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Instructions::available` has asked the processor.
            Instructions::Avx2 => unsafe { avx2::occluded(&self.tree, ray) },
            Instructions::Portable => portable::occluded(&self.tree, ray),
        }
    }

    /// Closest hits of many rays, on all threads.
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn closest_batch(&self, rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len());
        rays.par_iter().zip(hits).with_min_len(256).for_each(|(ray, hit)| *hit = self.closest(ray));
    }

    /// Any-hit queries of many rays, on all threads.
    ///
    /// # Panics
    /// If `blocked` is not as long as `rays`.
    pub fn occluded_batch(&self, rays: &[Ray], blocked: &mut [bool]) {
        assert_eq!(rays.len(), blocked.len());
        rays.par_iter().zip(blocked).with_min_len(256).for_each(|(ray, b)| *b = self.occluded(ray));
    }
}
