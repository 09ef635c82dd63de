//! The obvhs crate, what a Rust program would otherwise pick.

use farlight_gi_solver::tracer::Ray;
use glam::Vec3;
use glam34::Vec3A;
use obvhs::{
    BvhBuildParams,
    bvh2::{Bvh2, builder::build_bvh2_from_tris},
    ray::RayHit,
    rt_triangle::RtTriangle,
    triangle::Triangle,
};

use crate::Peer;

/// Its binary tree with the slow preset, triangles in the order of the tree.
pub(crate) struct Obvhs {
    bvh: Bvh2,
    triangles: Vec<RtTriangle>,
}

impl Obvhs {
    pub(crate) fn new(triangles: &[[Vec3; 3]]) -> Self {
        let triangles: Vec<Triangle> = triangles
            .iter()
            .map(|corners| {
                let [v0, v1, v2] = corners.map(|p| Vec3A::from_array(p.to_array()));
                Triangle { v0, v1, v2 }
            })
            .collect();
        let params = BvhBuildParams::slow_build();
        let bvh = build_bvh2_from_tris(&triangles, params, &mut Default::default());
        let triangles = bvh
            .primitive_indices
            .iter()
            .map(|&i| &triangles[i as usize])
            .map(|t| RtTriangle::new(t.v0, t.v1, t.v2))
            .collect();
        Self { bvh, triangles }
    }
}

fn convert(ray: &Ray) -> obvhs::ray::Ray {
    let vector = |v: Vec3| Vec3A::from_array(v.to_array());
    obvhs::ray::Ray::new(vector(ray.origin), vector(ray.direction), ray.t_min, ray.t_max)
}

impl Peer for Obvhs {
    fn name(&self) -> String {
        "obvhs 0.4 BVH2 (slow preset)".into()
    }

    #[inline]
    fn closest(&self, ray: &Ray) -> f32 {
        let mut hit = RayHit::none();
        self.bvh.ray_traverse(convert(ray), &mut hit, |ray, i| self.triangles[i].intersect(ray));
        hit.t
    }

    #[inline]
    fn occluded(&self, ray: &Ray) -> bool {
        !self.bvh.ray_traverse_miss(convert(ray), |ray, i| self.triangles[i].intersect(ray))
    }
}
