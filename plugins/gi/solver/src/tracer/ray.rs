//! What is computed once for a ray.

use super::Ray;

/// Rays and triangles with a coordinate beyond this are left out, so that no product of the
/// triangle test overflows.
pub(super) const FAR: f32 = 1.0e12;

/// By how much boxes are grown, in units of the largest coordinate: 8 units in the last place.
/// The bound for the rounding of a slab test and of the sheared corners together is 4.
pub(super) const PAD: f32 = 1.0 / (1 << 20) as f32;

/// Components of the direction count as at least this much of the largest one where they are
/// divided by, so that there is no infinity.
pub(super) const LEAST: f32 = 1.0e-18;

/// The order of the axes, by which of them is the last.
pub(super) const AXES: [[usize; 3]; 3] = [[2, 1, 0], [0, 2, 1], [1, 0, 2]];

/// The frame of the triangle test: the ray's direction, divided by its largest component's
/// magnitude, is the last axis, along which `t` counts.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) origin: [f32; 3],
    /// The axes, that of the largest component last.
    pub(super) axis: [usize; 3],
    /// Slopes of the two other axes.
    pub(super) shear: [f32; 2],
    /// Sign of the largest component.
    pub(super) sign: f32,
    pub(super) t_min: f32,
    pub(super) t_max: f32,
    /// Caller's `t` = `t` here / `scale`.
    pub(super) scale: f32,
}

impl Frame {
    /// Nothing for a ray that can't hit: not finite, without direction, or with an empty interval.
    #[inline(always)]
    pub(super) fn new(ray: &Ray) -> Option<Self> {
        let origin = ray.origin.to_array();
        let direction = ray.direction.to_array();
        let size = direction.map(f32::abs);
        let last = if size[2] > max(size[0], size[1]) { 2 } else { (size[1] > size[0]).into() };
        let axis: [usize; 3] = AXES[last];
        let scale = size[last];
        // Comparisons with NaN are false.
        let valid = (scale > 0.0)
            & size.iter().all(|&s| s < f32::INFINITY)
            & origin.iter().all(|x| x.abs() <= FAR)
            & (ray.t_min <= ray.t_max);
        valid.then(|| Self {
            origin,
            axis,
            shear: [direction[axis[0]] / direction[last], direction[axis[1]] / direction[last]],
            sign: 1.0f32.copysign(direction[last]),
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
