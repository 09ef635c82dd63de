//! The tree in memory: eight children a node, four triangles a pack, both as structures of arrays.

/// Children of a node.
pub(super) const WIDTH: usize = 8;
/// Triangles of a pack.
pub(super) const LANES: usize = 4;
/// A tree is never deeper than this (the builder sees to it), so that the stack has a fixed size.
pub(super) const MAX_DEPTH: usize = 64;
/// Entries of a traversal stack: each level leaves at most `WIDTH - 1` behind, and a node's
/// children are written as one block of `WIDTH`.
pub(super) const STACK: usize = MAX_DEPTH * (WIDTH - 1) + 2 * WIDTH;

/// Eight boxes and what is inside each.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Rows: min x, min y, min z, max x, max y, max z. An empty child has min +inf and max -inf.
    pub(super) bounds: [[f32; WIDTH]; 6],
    /// The children, in the order in which an any-hit ray asks them.
    pub(super) child: [Child; WIDTH],
    /// Children from near to far, one order for each octant of ray directions: entry `i` holds in
    /// bits `3 * octant` to `3 * octant + 2` the child that comes `i`-th. Bit 0 of the octant is
    /// set if the direction's x is negative, bit 1 for y, bit 2 for z.
    pub(super) order: [u32; WIDTH],
}

impl Node {
    /// A node without children.
    pub(super) const EMPTY: Self = Self {
        bounds: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        child: [Child(0); WIDTH],
        order: [0; WIDTH],
    };
}

/// Index of a node, or a run of triangle packs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(transparent)]
pub(super) struct Child(pub(super) u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const COUNT_BITS: u32 = 3;
    /// Most packs of one leaf.
    pub(super) const MAX_PACKS: usize = 1 << Self::COUNT_BITS;
    /// Most nodes, and most packs, that can be addressed.
    pub(super) const MAX_INDEX: usize = 1 << (31 - Self::COUNT_BITS);

    pub(super) fn node(index: usize) -> Self {
        debug_assert!(index < Self::MAX_INDEX);
        Self(index as u32)
    }

    pub(super) fn leaf(first: usize, packs: usize) -> Self {
        debug_assert!((1..=Self::MAX_PACKS).contains(&packs) && first < Self::MAX_INDEX);
        Self(Self::LEAF | (first as u32) << Self::COUNT_BITS | (packs - 1) as u32)
    }

    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Of a node: its index.
    #[inline(always)]
    pub(super) fn index(self) -> usize {
        self.0 as usize
    }

    /// Of a leaf: its packs.
    #[inline(always)]
    pub(super) fn packs(self) -> std::ops::Range<usize> {
        let first = ((self.0 & !Self::LEAF) >> Self::COUNT_BITS) as usize;
        first..first + (self.0 as usize & (Self::MAX_PACKS - 1)) + 1
    }
}

/// Four triangles.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub(super) struct Pack {
    /// Corner, axis, triangle. An unused lane holds NaN, which no test accepts.
    pub(super) corner: [[[f32; LANES]; 3]; 3],
    /// Indices in the caller's list.
    pub(super) triangle: [u32; LANES],
}

impl Pack {
    /// No triangle.
    pub(super) const EMPTY: Self =
        Self { corner: [[[f32::NAN; LANES]; 3]; 3], triangle: [u32::MAX; LANES] };
}

/// Everything that a ray needs.
#[derive(Clone, Default)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    pub(super) packs: Vec<Pack>,
}

impl Tree {
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.packs.as_slice())
    }
}
