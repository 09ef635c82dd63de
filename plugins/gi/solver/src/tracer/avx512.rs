//! The kernel for processors with AVX-512: that of AVX2 with its masks and compressing moves.

use std::arch::x86_64::*;

use super::{
    Hit, Ray,
    avx2::{self, Avx2, Sorted},
    node::{Child, Node, Pack, Tree, WIDTH},
    ray::Frame,
    traverse::{self, Kernel},
    triangle::Best,
};

/// Whether this processor can run the kernel.
pub(super) fn available() -> bool {
    avx2::available() && is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl")
}

/// # Safety
/// [`available`] must have said yes.
#[target_feature(enable = "avx512f,avx512vl,avx2,fma,popcnt,bmi1,bmi2,lzcnt")]
pub(super) unsafe fn closest(tree: &Tree, ray: &Ray) -> Hit {
    // SAFETY: the caller's promise.
    unsafe { traverse::closest::<Avx512>(tree, ray) }
}

/// # Safety
/// [`available`] must have said yes.
#[target_feature(enable = "avx512f,avx512vl,avx2,fma,popcnt,bmi1,bmi2,lzcnt")]
pub(super) unsafe fn occluded(tree: &Tree, ray: &Ray) -> bool {
    // SAFETY: the caller's promise.
    unsafe { traverse::occluded::<Avx512>(tree, ray) }
}

struct Avx512(Avx2);

impl Kernel for Avx512 {
    #[inline(always)]
    unsafe fn new(ray: &Ray) -> Option<Self> {
        // SAFETY: the features are the trait's promise.
        unsafe { Avx2::new(ray) }.map(Self)
    }

    #[inline(always)]
    fn frame(&self) -> &Frame {
        self.0.frame()
    }

    #[inline(always)]
    unsafe fn children(
        &self,
        node: &Node,
        limit: f32,
        child: *mut Child,
        distance: *mut f32,
    ) -> (usize, Child) {
        // SAFETY: there is room for eight; the features are the trait's promise.
        unsafe {
            let order = _mm256_load_si256(node.order.as_ptr().cast());
            let order = _mm256_srl_epi32(order, _mm_cvtsi32_si128(self.0.order_shift as i32));
            let children = _mm256_load_si256(node.child.as_ptr().cast());
            let children = _mm256_permutexvar_epi32(order, children);
            let mut sorted = Sorted([Child(0); WIDTH]);
            _mm256_store_si256(sorted.0.as_mut_ptr().cast(), children);
            let (enter, leave) = self.0.slabs(node, _mm256_set1_ps(limit));
            let enter = _mm256_permutexvar_ps(order, enter);
            let leave = _mm256_permutexvar_ps(order, leave);
            let mask = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(enter, leave);
            let nearest =
                *sorted.0.get_unchecked(31 - (u32::from(mask) | 1).leading_zeros() as usize);
            _mm256_storeu_si256(child.cast(), _mm256_maskz_compress_epi32(mask, children));
            _mm256_storeu_ps(distance, _mm256_maskz_compress_ps(mask, enter));
            (mask.count_ones() as usize, nearest)
        }
    }

    #[inline(always)]
    unsafe fn any_children(&self, node: &Node, child: *mut Child) -> (usize, Child) {
        // Compressing moves aren't faster here.
        // SAFETY: there is room for eight; the features are the trait's promise.
        unsafe { self.0.any_children(node, child) }
    }

    #[inline(always)]
    unsafe fn closest(&self, pack: &Pack, best: &mut Best) {
        // SAFETY: the features are the trait's promise.
        unsafe { self.0.closest(pack, best) }
    }

    #[inline(always)]
    unsafe fn any(&self, pack: &Pack) -> bool {
        // SAFETY: the features are the trait's promise.
        unsafe { self.0.any(pack) }
    }
}
