//! The kernel for processors with AVX2 and FMA.

use std::arch::x86_64::*;

use super::{
    Hit, Ray,
    node::{Child, LANES, Node, Pack, Tree, WIDTH},
    ray::{AXES, FAR, Frame, LEAST, PAD, max},
    traverse::{self, Kernel},
    triangle::Best,
};

/// Whether this processor can run the kernel.
pub(super) fn available() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("popcnt")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
}

/// # Safety
/// [`available`] must have said yes.
#[target_feature(enable = "avx2,fma,popcnt,bmi1,bmi2,lzcnt")]
pub(super) unsafe fn closest(tree: &Tree, ray: &Ray) -> Hit {
    // SAFETY: the caller's promise.
    unsafe { traverse::closest::<Avx2>(tree, ray) }
}

/// # Safety
/// [`available`] must have said yes.
#[target_feature(enable = "avx2,fma,popcnt,bmi1,bmi2,lzcnt")]
pub(super) unsafe fn occluded(tree: &Tree, ray: &Ray) -> bool {
    // SAFETY: the caller's promise.
    unsafe { traverse::occluded::<Avx2>(tree, ray) }
}

/// For each mask of eight bits the positions of its set bits, the highest first.
static COMPACT: [[u8; WIDTH]; 256] = {
    let mut table = [[0; WIDTH]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < WIDTH {
            if mask >> (WIDTH - 1 - bit) & 1 == 1 {
                table[mask][count] = (WIDTH - 1 - bit) as u8;
                count += 1;
            }
            bit += 1;
        }
        mask += 1;
    }
    table
};

/// Where in `Node::bounds` the rows begin through which a ray enters and leaves, by the signs of
/// its direction.
static ROWS: [[[usize; 3]; 2]; 8] = {
    let mut table = [[[0; 3]; 2]; 8];
    let mut i = 0;
    while i < 24 {
        let (octant, axis) = (i / 3, i % 3);
        let negative = octant >> axis & 1;
        table[octant][0][axis] = (axis + 3 * negative) * WIDTH;
        table[octant][1][axis] = (axis + 3 - 3 * negative) * WIDTH;
        i += 1;
    }
    table
};

/// [`AXES`] for `vpermilps`.
static PERMUTE: [[i32; 4]; 3] = [[2, 1, 0, 3], [0, 2, 1, 3], [1, 0, 2, 3]];

/// One ray's constants, most of them in all lanes.
struct Avx2 {
    frame: Frame,
    /// Reciprocal direction.
    inverse: [__m256; 3],
    /// Plane distance = plane * inverse + offset, rounded towards the ray's start ...
    near: [__m256; 3],
    /// ... and towards its end.
    far: [__m256; 3],
    t_min: __m256,
    t_max: __m256,
    /// In the frame's order.
    origin: [__m128; 3],
    shear: [__m128; 2],
    sign: __m128,
    /// Of `ROWS`.
    near_row: [usize; 3],
    far_row: [usize; 3],
    /// Where in a corner of a `Pack` the frame's axes begin.
    corner_row: [usize; 3],
    /// Three times the octant.
    order_shift: u32,
}

/// The largest of the first three lanes, in these.
#[inline(always)]
unsafe fn largest(x: __m128) -> __m128 {
    // SAFETY: SSE is part of the architecture's base.
    unsafe {
        let turned = _mm_shuffle_ps::<0b11_00_10_01>(x, x);
        let again = _mm_shuffle_ps::<0b11_01_00_10>(x, x);
        _mm_max_ps(_mm_max_ps(x, turned), again)
    }
}

/// The first three lanes, each in a vector of its own.
#[inline(always)]
unsafe fn spread(x: __m128) -> [__m256; 3] {
    // SAFETY: the features are the caller's promise.
    unsafe {
        let x = _mm256_castps128_ps256(x);
        [
            _mm256_permutevar8x32_ps(x, _mm256_setzero_si256()),
            _mm256_permutevar8x32_ps(x, _mm256_set1_epi32(1)),
            _mm256_permutevar8x32_ps(x, _mm256_set1_epi32(2)),
        ]
    }
}

impl Avx2 {
    /// Where the ray enters and leaves the eight boxes.
    #[inline(always)]
    unsafe fn slabs(&self, node: &Node, limit: __m256) -> (__m256, __m256) {
        // SAFETY: the rows are the node's; the features are the trait's promise.
        unsafe {
            let bounds = node.bounds.as_ptr().cast::<f32>();
            let near = |a: usize| {
                let plane = _mm256_load_ps(bounds.add(self.near_row[a]));
                _mm256_fmadd_ps(plane, self.inverse[a], self.near[a])
            };
            let far = |a: usize| {
                let plane = _mm256_load_ps(bounds.add(self.far_row[a]));
                _mm256_fmadd_ps(plane, self.inverse[a], self.far[a])
            };
            let enter = _mm256_max_ps(near(0), near(1));
            let enter = _mm256_max_ps(enter, _mm256_max_ps(near(2), self.t_min));
            let leave = _mm256_min_ps(far(0), far(1));
            let leave = _mm256_min_ps(leave, _mm256_min_ps(far(2), limit));
            (enter, leave)
        }
    }

    /// A row of corners relative to the ray's origin.
    #[inline(always)]
    unsafe fn row(&self, corner: &[[f32; LANES]; 3], axis: usize) -> __m128 {
        // SAFETY: the row is the corner's; the features are the trait's promise.
        unsafe {
            let row = corner.as_ptr().cast::<f32>().add(self.corner_row[axis]);
            _mm_sub_ps(_mm_load_ps(row), self.origin[axis])
        }
    }

    /// A corner of all triangles relative to the ray, sheared so that the ray is the third axis.
    #[inline(always)]
    unsafe fn corner(&self, corner: &[[f32; LANES]; 3]) -> (__m128, __m128, __m128) {
        // SAFETY: the features are the trait's promise.
        unsafe {
            let z = self.row(corner, 2);
            let x = _mm_sub_ps(self.row(corner, 0), _mm_mul_ps(self.shear[0], z));
            let y = _mm_sub_ps(self.row(corner, 1), _mm_mul_ps(self.shear[1], z));
            (x, y, z)
        }
    }

    /// Edge functions, twice the signed area, distance, and the lanes that may be hit.
    #[inline(always)]
    unsafe fn edges(&self, pack: &Pack, limit: f32) -> Edges {
        // SAFETY: the features are the trait's promise.
        unsafe {
            let (ax, ay, az) = self.corner(&pack.corner[0]);
            let (bx, by, bz) = self.corner(&pack.corner[1]);
            let (cx, cy, cz) = self.corner(&pack.corner[2]);
            // Not fused: the sign must flip exactly when the edge's corners are swapped.
            let u = _mm_sub_ps(_mm_mul_ps(cx, by), _mm_mul_ps(cy, bx));
            let v = _mm_sub_ps(_mm_mul_ps(ax, cy), _mm_mul_ps(ay, cx));
            let w = _mm_sub_ps(_mm_mul_ps(bx, ay), _mm_mul_ps(by, ax));
            let zero = _mm_setzero_ps();
            let least = _mm_min_ps(_mm_min_ps(u, v), w);
            let most = _mm_max_ps(_mm_max_ps(u, v), w);
            let inside = _mm_or_ps(_mm_cmpge_ps(least, zero), _mm_cmple_ps(most, zero));
            if _mm_movemask_ps(inside) == 0 {
                return Edges { v, w, det: zero, t: zero, hits: 0, edge_on: 0 };
            }
            let det = _mm_add_ps(_mm_add_ps(u, v), w);
            let depth =
                _mm_add_ps(_mm_add_ps(_mm_mul_ps(u, az), _mm_mul_ps(v, bz)), _mm_mul_ps(w, cz));
            let t = _mm_mul_ps(_mm_div_ps(depth, det), self.sign);
            let range = _mm_and_ps(
                _mm_cmpge_ps(t, _mm256_castps256_ps128(self.t_min)),
                _mm_cmple_ps(t, _mm_set1_ps(limit)),
            );
            // Where `det` is zero `t` is NaN, which is out of range.
            Edges {
                v,
                w,
                det,
                t,
                hits: _mm_movemask_ps(_mm_and_ps(inside, range)) as u32,
                edge_on: _mm_movemask_ps(_mm_and_ps(inside, _mm_cmpeq_ps(det, zero))) as u32,
            }
        }
    }
}

struct Edges {
    v: __m128,
    w: __m128,
    det: __m128,
    t: __m128,
    hits: u32,
    edge_on: u32,
}

#[repr(C, align(32))]
struct Sorted([Child; WIDTH]);

#[repr(C, align(16))]
struct Lanes([f32; LANES]);

#[inline(always)]
unsafe fn lanes(x: __m128) -> Lanes {
    let mut out = Lanes([0.0; LANES]);
    // SAFETY: SSE is part of the architecture's base.
    unsafe { _mm_store_ps(out.0.as_mut_ptr(), x) };
    out
}

impl Kernel for Avx2 {
    #[inline(always)]
    unsafe fn new(ray: &Ray) -> Option<Self> {
        // SAFETY: `Ray` is eight floats in this order; the features are the trait's promise.
        unsafe {
            let floats = std::ptr::from_ref(ray).cast::<f32>();
            let origin = _mm_loadu_ps(floats); // and t_min
            let direction = _mm_loadu_ps(floats.add(4)); // and t_max
            let sign_bit = _mm_set1_ps(-0.0);
            let size = _mm_andnot_ps(sign_bit, direction);
            let distance = _mm_andnot_ps(sign_bit, origin);
            let scales = largest(size);
            let scale = _mm_cvtss_f32(scales);
            let finite = _mm_cmplt_ps(size, _mm_set1_ps(f32::INFINITY));
            let near = _mm_cmple_ps(distance, _mm_set1_ps(FAR));
            let valid = _mm_movemask_ps(_mm_and_ps(finite, near)) & 7 == 7;
            // Comparisons with NaN are false.
            if !(valid & (scale > 0.0) & (ray.t_min <= ray.t_max)) {
                return None;
            }
            let scales = _mm_shuffle_ps::<0>(scales, scales);
            let last = _mm_movemask_ps(_mm_cmpeq_ps(size, scales)).trailing_zeros() as usize % 4;
            let order = _mm_loadu_si128(PERMUTE.get_unchecked(last).as_ptr().cast());
            let permuted = _mm_permutevar_ps(direction, order);
            let main = _mm_shuffle_ps::<0b10_10_10_10>(permuted, permuted);
            let shear = _mm_div_ps(permuted, main);
            let from = _mm_permutevar_ps(origin, order);

            let least =
                _mm_max_ps(_mm_mul_ps(scales, _mm_set1_ps(LEAST)), _mm_set1_ps(f32::MIN_POSITIVE));
            let magnitude = _mm_div_ps(scales, _mm_max_ps(size, least));
            let inverse = _mm_or_ps(magnitude, _mm_and_ps(direction, sign_bit));
            let reach = largest(distance);
            let reach = _mm_shuffle_ps::<0>(reach, reach);
            let pad = _mm_mul_ps(_mm_mul_ps(reach, _mm_set1_ps(PAD)), magnitude);
            let octant = _mm_movemask_ps(direction) as usize & 7;
            let [near_row, far_row] = *ROWS.get_unchecked(octant);

            let axis = *AXES.get_unchecked(last);
            let frame = Frame {
                origin: ray.origin.to_array(),
                axis,
                shear: [_mm_cvtss_f32(shear), _mm_cvtss_f32(_mm_movehdup_ps(shear))],
                sign: 1.0f32.copysign(_mm_cvtss_f32(main)),
                t_min: max(ray.t_min, 0.0) * scale,
                t_max: ray.t_max * scale,
                scale,
            };
            Some(Self {
                frame,
                inverse: spread(inverse),
                near: spread(_mm_fnmsub_ps(origin, inverse, pad)),
                far: spread(_mm_fnmadd_ps(origin, inverse, pad)),
                t_min: _mm256_set1_ps(frame.t_min),
                t_max: _mm256_set1_ps(frame.t_max),
                origin: spread(from).map(|x| _mm256_castps256_ps128(x)),
                shear: [
                    _mm_shuffle_ps::<0>(shear, shear),
                    _mm_shuffle_ps::<0b01_01_01_01>(shear, shear),
                ],
                sign: _mm_set1_ps(frame.sign),
                near_row,
                far_row,
                corner_row: axis.map(|a| a * LANES),
                order_shift: 3 * octant as u32,
            })
        }
    }

    #[inline(always)]
    fn frame(&self) -> &Frame {
        &self.frame
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
            let (enter, leave) = self.slabs(node, _mm256_set1_ps(limit));
            let met = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave);
            let order = _mm256_load_si256(node.order.as_ptr().cast());
            let order = _mm256_srl_epi32(order, _mm_cvtsi32_si128(self.order_shift as i32));
            let children = _mm256_load_si256(node.child.as_ptr().cast());
            let children = _mm256_permutevar8x32_epi32(children, order);
            let mut sorted = Sorted([Child(0); WIDTH]);
            _mm256_store_si256(sorted.0.as_mut_ptr().cast(), children);
            let mask = _mm256_movemask_ps(_mm256_permutevar8x32_ps(met, order)) as u32;
            if mask == 0 {
                return (0, Child(0));
            }
            let nearest = *sorted.0.get_unchecked(mask.trailing_zeros() as usize);
            let compact = _mm_loadl_epi64(COMPACT.get_unchecked(mask as usize).as_ptr().cast());
            let compact = _mm256_cvtepu8_epi32(compact);
            _mm256_storeu_si256(child.cast(), _mm256_permutevar8x32_epi32(children, compact));
            let enter = _mm256_permutevar8x32_ps(enter, order);
            _mm256_storeu_ps(distance, _mm256_permutevar8x32_ps(enter, compact));
            (mask.count_ones() as usize, nearest)
        }
    }

    #[inline(always)]
    unsafe fn any_children(&self, node: &Node, child: *mut Child) -> (usize, Child) {
        // SAFETY: there is room for eight; the features are the trait's promise.
        unsafe {
            let (enter, leave) = self.slabs(node, self.t_max);
            let met = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave);
            let mask = _mm256_movemask_ps(met) as u32;
            if mask == 0 {
                return (0, Child(0));
            }
            let first = *node.child.get_unchecked(mask.trailing_zeros() as usize);
            let compact = _mm_loadl_epi64(COMPACT.get_unchecked(mask as usize).as_ptr().cast());
            let compact = _mm256_cvtepu8_epi32(compact);
            let children = _mm256_load_si256(node.child.as_ptr().cast());
            _mm256_storeu_si256(child.cast(), _mm256_permutevar8x32_epi32(children, compact));
            (mask.count_ones() as usize, first)
        }
    }

    #[inline(always)]
    unsafe fn closest<'a>(&self, pack: &'a Pack, best: &mut Best<'a>) -> bool {
        // SAFETY: the features are the trait's promise.
        unsafe {
            let e = self.edges(pack, best.t);
            let mut hits = e.hits;
            if hits != 0 {
                let (t, v, w, det) = (lanes(e.t), lanes(e.v), lanes(e.w), lanes(e.det));
                while hits != 0 {
                    let lane = hits.trailing_zeros() as usize & (LANES - 1);
                    if t.0[lane] <= best.t {
                        *best = Best {
                            t: t.0[lane],
                            v: v.0[lane],
                            w: w.0[lane],
                            det: det.0[lane],
                            pack: Some(pack),
                            lane,
                        };
                    }
                    hits &= hits - 1;
                }
            }
            e.edge_on != 0
        }
    }

    #[inline(always)]
    unsafe fn any(&self, pack: &Pack) -> (bool, bool) {
        // SAFETY: the features are the trait's promise.
        let e = unsafe { self.edges(pack, self.frame.t_max) };
        (e.hits != 0, e.edge_on != 0)
    }
}
