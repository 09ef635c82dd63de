//! What is computed once for a ray.

use super::Ray;

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
    /// Rows of `Node::bounds` in which the ray enters, by axis.
    pub(super) near_row: [usize; 3],
    /// Rows in which it leaves.
    pub(super) far_row: [usize; 3],
    /// The axes, that of the largest component last.
    pub(super) axis: [usize; 3],
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
        let z = if size[0] > size[1] {
            if size[0] > size[2] { 0 } else { 2 }
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        let axis = [(z + 1) % 3, (z + 2) % 3, z];
        let scale = size[z];
        let reach = origin[0].abs().max(origin[1].abs()).max(origin[2].abs());
        let sum = size[0] + size[1] + size[2];
        // `max` drops NaN, sums don't.
        let valid = scale > 0.0
            && sum.is_finite()
            && reach <= FAR
            && !(origin[0] + origin[1] + origin[2]).is_nan()
            && ray.t_min <= ray.t_max;
        if !valid {
            return None;
        }
        let mut inverse = [0.0; 3];
        let mut near = [0.0; 3];
        let mut far = [0.0; 3];
        let mut near_row = [0; 3];
        let mut far_row = [0; 3];
        let mut order_shift = 0;
        for a in 0..3 {
            let d = direction[a] / scale;
            let i = (1.0 / d.abs().max(1.0e-18)).copysign(d);
            inverse[a] = i;
            let pad = reach * PAD * i.abs();
            near[a] = -origin[a] * i - pad;
            far[a] = -origin[a] * i + pad;
            let negative = usize::from(i < 0.0);
            near_row[a] = a + 3 * negative;
            far_row[a] = a + 3 - 3 * negative;
            order_shift |= (negative as u32) << a;
        }
        Some(Self {
            origin,
            inverse,
            near,
            far,
            near_row,
            far_row,
            axis,
            shear: [direction[axis[0]] / direction[z], direction[axis[1]] / direction[z]],
            sign: 1.0f32.copysign(direction[z]),
            order_shift: 3 * order_shift,
            t_min: ray.t_min.max(0.0) * scale,
            t_max: ray.t_max * scale,
            scale,
        })
    }
}
