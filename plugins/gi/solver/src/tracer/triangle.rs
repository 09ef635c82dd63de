//! What all triangle tests share: the closest hit so far and the exact answer for edge-on triangles.

use glam::DVec3;

use super::{
    Hit, Ray,
    node::{LANES, Pack},
    ray::{Frame, max, min},
};

/// The closest hit so far, in the units of [`Frame`].
#[derive(Clone, Copy)]
pub(super) struct Best<'a> {
    pub(super) t: f32,
    /// Edge functions of the second and third corner and the sum of all three.
    pub(super) v: f32,
    pub(super) w: f32,
    pub(super) det: f32,
    /// Where the triangle is, if there is one.
    pub(super) pack: Option<&'a Pack>,
    pub(super) lane: usize,
}

impl Best<'_> {
    #[inline(always)]
    pub(super) fn new(t_max: f32) -> Self {
        Self { t: t_max, v: 0.0, w: 0.0, det: 1.0, pack: None, lane: 0 }
    }

    #[inline(always)]
    pub(super) fn hit(&self, ray: &Ray, frame: &Frame) -> Hit {
        let Some(pack) = self.pack else { return Hit::NONE };
        let lane = self.lane & (LANES - 1);
        let t = plane_distance(ray, pack, lane);
        // Seen nearly edge-on there is no plane to speak of.
        let t_min = max(ray.t_min, 0.0);
        let t = if t >= t_min && t <= ray.t_max {
            t
        } else {
            // The interval was rounded when it was scaled.
            max(min(self.t / frame.scale, ray.t_max), t_min)
        };
        let inverse = 1.0 / self.det;
        Hit { t, u: self.v * inverse, v: self.w * inverse, triangle: pack.triangle[lane] }
    }
}

/// Where the ray meets the triangle's plane. The edge functions' distance is as exact across the
/// plane, but where the ray grazes it, this one is much more exact along the ray.
#[inline(always)]
fn plane_distance(ray: &Ray, pack: &Pack, lane: usize) -> f32 {
    let [a, b, c] = [0, 1, 2].map(|i| {
        let p = &pack.corner[i];
        DVec3::new(p[0][lane].into(), p[1][lane].into(), p[2][lane].into())
    });
    let normal = (b - a).cross(c - a);
    let depth = (a - ray.origin.as_dvec3()).dot(normal);
    (depth / ray.direction.as_dvec3().dot(normal)) as f32
}

/// The triangle test in double precision, for a lane whose edge functions are all zero in single
/// precision: their products are exact here, so the ray can't slip through a triangle that is
/// nearly edge-on, and one that has no area in projection is not hit.
#[cold]
#[inline(never)]
pub(super) fn edge_on<'a>(
    frame: &Frame,
    pack: &'a Pack,
    lane: usize,
    limit: f32,
) -> Option<Best<'a>> {
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
        pack: Some(pack),
        lane,
    })
}
