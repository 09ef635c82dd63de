//! What all triangle tests share: the closest hit so far and the exact answer for edge-on triangles.

use super::{
    Hit,
    node::{LANES, Pack},
    ray::Frame,
};

/// The closest hit so far, in the units of [`Frame`].
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub(super) t: f32,
    /// Edge functions of the second and third corner and the sum of all three.
    pub(super) v: f32,
    pub(super) w: f32,
    pub(super) det: f32,
    pub(super) triangle: u32,
}

impl Best {
    #[inline(always)]
    pub(super) fn new(t_max: f32) -> Self {
        Self { t: t_max, v: 0.0, w: 0.0, det: 1.0, triangle: Hit::MISS }
    }

    #[inline(always)]
    pub(super) fn hit(&self, frame: &Frame) -> Hit {
        if self.triangle == Hit::MISS {
            return Hit::NONE;
        }
        Hit {
            t: self.t / frame.scale,
            u: self.v / self.det,
            v: self.w / self.det,
            triangle: self.triangle,
        }
    }
}

/// The triangle test in double precision, for a lane whose edge functions are all zero in single
/// precision: their products are exact here, so the ray can't slip through a triangle that is
/// nearly edge-on, and one that has no area in projection is not hit.
#[cold]
#[inline(never)]
pub(super) fn edge_on(frame: &Frame, pack: &Pack, lane: usize, limit: f32) -> Option<Best> {
    debug_assert!(lane < LANES);
    let [x, y, z] = frame.axis;
    let corner = [0, 1, 2].map(|c| {
        let p = |a: usize| pack.corner[c][a][lane] - frame.origin[a];
        let depth = p(z);
        [p(x) - frame.shear[0] * depth, p(y) - frame.shear[1] * depth, depth].map(f64::from)
    });
    let [a, b, c] = corner;
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    let det = u + v + w;
    if !inside || det == 0.0 {
        return None;
    }
    let t = ((u * a[2] + v * b[2] + w * c[2]) / det) as f32 * frame.sign;
    (t >= frame.t_min && t <= limit).then(|| Best {
        t,
        v: (v / det) as f32,
        w: (w / det) as f32,
        det: 1.0,
        triangle: pack.triangle[lane],
    })
}
