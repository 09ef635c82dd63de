//! The way of a ray through the tree, over a [`Kernel`] that knows the processor's instructions.

use std::mem::MaybeUninit;

use super::{
    Hit, Ray,
    node::{Child, Node, Pack, STACK, Tree},
    portable,
    ray::Frame,
    triangle::Best,
};

/// One ray's tests against eight boxes and four triangles.
///
/// # Safety
/// The implementation's instructions must exist on this processor.
pub(super) trait Kernel: Sized {
    /// Nothing for a ray that can't hit, as [`Frame::new`].
    unsafe fn new(ray: &Ray) -> Option<Self>;

    fn frame(&self) -> &Frame;

    /// Writes the children that the ray meets before `limit`, the nearest last, and returns how
    /// many and, for a shorter way to it, the nearest; there must be room for `WIDTH`.
    unsafe fn children(
        &self,
        node: &Node,
        limit: f32,
        child: *mut Child,
        distance: *mut f32,
    ) -> (usize, Child);

    /// The same in the node's own order, the first child last, and without distances.
    unsafe fn any_children(&self, node: &Node, child: *mut Child) -> (usize, Child);

    /// Takes the pack's closest hit if it is closer. Says whether single precision can't tell; then
    /// the portable kernel has to.
    unsafe fn closest<'a>(&self, pack: &'a Pack, best: &mut Best<'a>) -> bool;

    /// Whether one of the pack's triangles is hit, or else whether single precision can't tell.
    unsafe fn any(&self, pack: &Pack) -> (bool, bool);
}

/// # Safety
/// As [`Kernel`].
#[inline(always)]
pub(super) unsafe fn closest<K: Kernel>(tree: &Tree, ray: &Ray) -> Hit {
    // SAFETY: the caller's promise.
    let Some(kernel) = (unsafe { K::new(ray) }) else { return Hit::NONE };
    if tree.nodes.is_empty() {
        return Hit::NONE;
    }
    let mut best = Best::new(kernel.frame().t_max);
    let mut child = [MaybeUninit::<Child>::uninit(); STACK];
    let mut distance = [MaybeUninit::<f32>::uninit(); STACK];
    let child = child.as_mut_ptr().cast::<Child>();
    let distance = distance.as_mut_ptr().cast::<f32>();
    // SAFETY: the stack has room for a tree of MAX_DEPTH, which the builder keeps to, entries below
    // `top` have been written, and the tree's indices lie in its arrays.
    unsafe {
        let mut next = Child::node(0);
        let mut top = 0;
        let mut doubtful = false;
        loop {
            if next.is_leaf() {
                for pack in next.packs() {
                    doubtful |= kernel.closest(tree.packs.get_unchecked(pack), &mut best);
                }
            } else {
                let node = tree.nodes.get_unchecked(next.index());
                let (count, nearest) =
                    kernel.children(node, best.t, child.add(top), distance.add(top));
                if count > 0 {
                    top += count - 1;
                    next = nearest;
                    continue;
                }
            }
            loop {
                if top == 0 {
                    // Done afterwards and rarely, so that the loop calls no function and keeps
                    // everything in registers.
                    if doubtful {
                        return portable::closest(tree, ray);
                    }
                    return best.hit(ray, kernel.frame());
                }
                top -= 1;
                if distance.add(top).read() <= best.t {
                    break;
                }
            }
            next = child.add(top).read();
        }
    }
}

/// # Safety
/// As [`Kernel`].
#[inline(always)]
pub(super) unsafe fn occluded<K: Kernel>(tree: &Tree, ray: &Ray) -> bool {
    // SAFETY: the caller's promise.
    let Some(kernel) = (unsafe { K::new(ray) }) else { return false };
    if tree.nodes.is_empty() {
        return false;
    }
    let mut child = [MaybeUninit::<Child>::uninit(); STACK];
    let child = child.as_mut_ptr().cast::<Child>();
    // SAFETY: as in `closest`.
    unsafe {
        let mut next = Child::node(0);
        let mut top = 0;
        let mut doubtful = false;
        loop {
            if next.is_leaf() {
                for pack in next.packs() {
                    let (hit, doubt) = kernel.any(tree.packs.get_unchecked(pack));
                    if hit {
                        return true;
                    }
                    doubtful |= doubt;
                }
            } else {
                let node = tree.nodes.get_unchecked(next.index());
                let (count, first) = kernel.any_children(node, child.add(top));
                if count > 0 {
                    top += count - 1;
                    next = first;
                    continue;
                }
            }
            if top == 0 {
                return doubtful && portable::occluded(tree, ray);
            }
            top -= 1;
            next = child.add(top).read();
        }
    }
}
