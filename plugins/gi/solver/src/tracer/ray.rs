//! What is computed once for a ray.

use super::{
    Ray,
    node::{LANES, WIDTH},
};

/// Rays and triangles with a coordinate beyond this are left out, so that no product of the
/// triangle test overflows.
pub(super) const FAR: f32 = 1.0e12;

/// By how much boxes are grown, in units of the largest coordinate: 8 units in the last place.
/// The bound for the rounding of a slab test and of the sheared corners together is 4.
pub(super) const PAD: f32 = 1.0 / (1 << 20) as f32;

/// A ray with its direction divided by the largest component's magnitude, so that `t` counts along
/// that axis, and everything else that stays the same along the way through the tree.
#[derive(Clone, Copy)]
pub(super) struct Prepared {
    pub(super) origin: [f32; 3],
    /// Reciprocal direction; never zero, never infinite.
    pub(super) inverse: [f32; 3],
    /// Plane distance = plane * inverse + offset, rounded towards the ray's start ...
    pub(super) near: [f32; 3],
    /// ... and towards its end.
    pub(super) far: [f32; 3],
    /// Where in `Node::bounds` the rows begin through which the ray enters, by axis.
    pub(super) near_row: [usize; 3],
    /// The same for leaving.
    pub(super) far_row: [usize; 3],
    /// The axes, that of the largest component last.
    pub(super) axis: [usize; 3],
    /// Where in a corner of a `Pack` the rows of these axes begin.
    pub(super) corner_row: [usize; 3],
    /// Slopes of the two other axes.
    pub(super) shear: [f32; 2],
    /// Sign of the largest component.
    pub(super) sign: f32,
    /// Three times the octant.
    pub(super) order_shift: u32,
    pub(super) t_min: f32,
    pub(super) t_max: f32,
    /// Caller's `t` = `t` here / `scale`.
    pub(super) scale: f32,
}

impl Prepared {
    /// Nothing for a ray that can't hit: not finite, without direction, or with an empty interval.
    #[inline(always)]
    pub(super) fn new(ray: &Ray) -> Option<Self> {
        let origin = ray.origin.to_array();
        let direction = ray.direction.to_array();
        let size = direction.map(f32::abs);
        let z = {
            let y = usize::from(size[1] > size[0]);
            if size[2] > max(size[0], size[1]) { 2 } else { y }
        };
        let x = (0b01_00_10 >> (2 * z)) & 3; // no remainders
        let y = (0b00_10_01 >> (2 * z)) & 3;
        let scale = max(max(size[0], size[1]), size[2]);
        let reach = max(max(origin[0].abs(), origin[1].abs()), origin[2].abs());
        // Comparisons and `max` may lose a NaN, sums don't.
        let valid = (scale > 0.0)
            & (size[0] + size[1] + size[2] < f32::INFINITY)
            & (reach <= FAR)
            & (origin[0] + origin[1] + origin[2]).is_finite()
            & (ray.t_min <= ray.t_max);
        if !valid {
            return None;
        }
        let least = max(scale * 1.0e-18, f32::MIN_POSITIVE);
        let pad = reach * PAD;
        let mut inverse = [0.0; 3];
        let mut near = [0.0; 3];
        let mut far = [0.0; 3];
        let mut near_row = [0; 3];
        let mut far_row = [0; 3];
        let mut order_shift = 0;
        for a in 0..3 {
            let magnitude = scale / max(size[a], least);
            let i = magnitude.copysign(direction[a]);
            inverse[a] = i;
            near[a] = -origin[a] * i - pad * magnitude;
            far[a] = -origin[a] * i + pad * magnitude;
            let negative = direction[a].to_bits() >> 31;
            near_row[a] = (a + 3 * negative as usize) * WIDTH;
            far_row[a] = (a + 3 - 3 * negative as usize) * WIDTH;
            order_shift |= negative << a;
        }
        Some(Self {
            origin,
            inverse,
            near,
            far,
            near_row,
            far_row,
            axis: [x, y, z],
            corner_row: [x * LANES, y * LANES, z * LANES],
            shear: [direction[x] / direction[z], direction[y] / direction[z]],
            sign: 1.0f32.copysign(direction[z]),
            order_shift: 3 * order_shift,
            t_min: max(ray.t_min, 0.0) * scale,
            t_max: ray.t_max * scale,
            scale,
        })
    }
}

/// `f32::max` without its rule for NaN, which costs three more instructions.
#[inline(always)]
pub(super) fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// `f32::min` likewise.
#[inline(always)]
pub(super) fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
