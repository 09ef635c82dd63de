//! Batches of closest-hit and any-hit rays over a BVH.

use glam::Vec3;
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    triangle::Triangle,
};
use rayon::prelude::*;

/// A ray segment. The direction need not be of unit length; `t` counts in its lengths.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Hits before this are ignored.
    pub t_min: f32,
    /// Where it goes.
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
    triangles: Vec<Triangle>,
    bvh: Option<CwBvh>,
}

impl Tracer {
    /// Builds the acceleration structure. Triangles that are not finite are never hit.
    #[must_use]
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        let convert = |p: Vec3| obvhs_vec(p);
        let triangles: Vec<Triangle> = triangles
            .iter()
            .map(|[a, b, c]| Triangle { v0: convert(*a), v1: convert(*b), v2: convert(*c) })
            .collect();
        let bvh = (!triangles.is_empty()).then(|| {
            build_cwbvh_from_tris(
                &triangles,
                BvhBuildParams::medium_build(),
                &mut Default::default(),
            )
        });
        Self { triangles, bvh }
    }

    /// The closest hit of one ray.
    #[must_use]
    pub fn closest(&self, ray: &Ray) -> Hit {
        let Some(bvh) = &self.bvh else { return Hit::NONE };
        let r = obvhs::ray::Ray::new(
            obvhs_vec(ray.origin),
            obvhs_vec(ray.direction),
            ray.t_min,
            ray.t_max,
        );
        let mut hit = obvhs::ray::RayHit::none();
        if !bvh.ray_traverse(r, &mut hit, |ray, id| {
            self.triangles[bvh.primitive_indices[id] as usize].intersect(ray)
        }) {
            return Hit::NONE;
        }
        let triangle = bvh.primitive_indices[hit.primitive_id as usize];
        let bary = self.triangles[triangle as usize].compute_barycentric(&r);
        Hit { t: hit.t, u: bary.x, v: bary.y, triangle }
    }

    /// Whether anything lies on the ray's segment.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.closest(ray).is_hit()
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

fn obvhs_vec(v: Vec3) -> <[f32; 3] as IntoObvhs>::Out {
    v.to_array().into_obvhs()
}

/// obvhs names another version of glam; arrays are the bridge.
trait IntoObvhs {
    type Out;
    fn into_obvhs(self) -> Self::Out;
}

impl IntoObvhs for [f32; 3] {
    type Out = glam34::Vec3A;
    fn into_obvhs(self) -> glam34::Vec3A {
        glam34::Vec3A::from_array(self)
    }
}
