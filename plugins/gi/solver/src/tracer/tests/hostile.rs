//! Scenes that trees don't like.

use glam::Vec3;

use super::{Random, soup, tracers};
use crate::tracer::{Hit, Ray, Tracer, node::MAX_DEPTH};

const WALL: [Vec3; 3] =
    [Vec3::new(-1.0, -1.0, 5.0), Vec3::new(1.0, -1.0, 5.0), Vec3::new(0.0, 1.0, 5.0)];

fn depth(tracer: &Tracer) -> usize {
    let mut todo = vec![(0, 1)];
    let mut depth = 0;
    while let Some((node, d)) = todo.pop() {
        depth = depth.max(d);
        let node = &tracer.tree.nodes[node];
        for (i, child) in node.child.iter().enumerate() {
            if node.bounds[0][i] <= node.bounds[3][i] && !child.is_leaf() {
                todo.push((child.index(), d + 1));
            }
        }
    }
    depth
}

#[test]
fn many_coincident_triangles() {
    let triangles = vec![WALL; 200_000];
    for tracer in tracers(&triangles) {
        assert!(depth(&tracer) <= MAX_DEPTH);
        let hit = tracer.closest(&Ray::new(Vec3::ZERO, Vec3::Z));
        assert!((hit.t - 5.0).abs() < 1e-5);
        assert!(tracer.occluded(&Ray::new(Vec3::ZERO, Vec3::Z)));
        assert_eq!(tracer.closest(&Ray::new(Vec3::ZERO, -Vec3::Z)), Hit::NONE);
    }
}

#[test]
fn long_strip_of_equal_triangles() {
    // All neighbours are equally good partners.
    let triangles: Vec<[Vec3; 3]> =
        (0..100_000).map(|i| WALL.map(|p| p + Vec3::X * (4 * i) as f32)).collect();
    for tracer in tracers(&triangles) {
        assert!(depth(&tracer) <= MAX_DEPTH);
        for i in (0..100_000).step_by(997) {
            let hit = tracer.closest(&Ray::new(Vec3::X * (4 * i) as f32, Vec3::Z));
            assert_eq!(hit.triangle, i);
        }
    }
}

#[test]
fn sizes_that_grow_exponentially() {
    // Nested like a matryoshka, which makes trees deep.
    let triangles: Vec<[Vec3; 3]> =
        (0..2000).map(|i| WALL.map(|p| p * 1.02f32.powi(i - 1000))).collect();
    for tracer in tracers(&triangles) {
        assert!(depth(&tracer) <= MAX_DEPTH);
        let hit = tracer.closest(&Ray::new(Vec3::ZERO, Vec3::Z));
        assert_eq!(hit.triangle, 0);
    }
}

#[test]
fn deep_trees_are_cut() {
    // 300 orders of magnitude can't be had in single precision; nested corners at one point can.
    let mut triangles = Vec::new();
    for i in 0..60_000 {
        let size = 1.0 + i as f32 / 64.0;
        triangles.push([Vec3::ZERO, Vec3::X * size, Vec3::new(0.0, size, size)]);
    }
    for tracer in tracers(&triangles) {
        assert!(depth(&tracer) <= MAX_DEPTH);
        let ray = Ray::new(Vec3::new(0.1, 5.0, 0.05), -Vec3::Y);
        assert!(tracer.closest(&ray).is_hit());
    }
}

#[test]
fn huge_and_tiny_coordinates_side_by_side() {
    let mut random = Random(8);
    let mut triangles = soup(300, 0.2, &mut random);
    triangles.push([Vec3::splat(9e11), Vec3::new(-9e11, 9e11, 0.0), Vec3::new(0.0, -9e11, 9e11)]);
    triangles.push([Vec3::splat(1e30), Vec3::new(-1e30, 1e30, 0.0), Vec3::new(0.0, -1e30, 1e30)]);
    triangles.push([Vec3::splat(1e-38), Vec3::new(-1e-38, 1e-38, 0.0), Vec3::X * 1e-38]);
    triangles.push([Vec3::ZERO, Vec3::X * 1e-44, Vec3::Y * 1e-44]);
    for tracer in tracers(&triangles) {
        for _ in 0..2000 {
            let ray = Ray::new(random.cube() * 2.0, random.cube());
            let hit = tracer.closest(&ray);
            assert_eq!(hit.is_hit(), tracer.occluded(&ray));
            assert!(!hit.is_hit() || (hit.t.is_finite() && hit.u.is_finite() && hit.v.is_finite()));
            assert_ne!(hit.triangle, 301, "beyond the limit");
        }
        let far = Ray::new(random.cube() * 8e11, Vec3::X);
        let _ = tracer.closest(&far);
    }
}

#[test]
fn batches_are_the_single_rays() {
    let mut random = Random(9);
    let triangles = soup(500, 0.2, &mut random);
    let tracer = Tracer::new(&triangles);
    for count in [0, 1, 7, 1000] {
        let rays: Vec<Ray> =
            (0..count).map(|_| Ray::new(random.cube() * 2.0, random.cube())).collect();
        let mut hits = vec![Hit::NONE; count];
        let mut blocked = vec![false; count];
        tracer.closest_batch(&rays, &mut hits);
        tracer.occluded_batch(&rays, &mut blocked);
        for ((ray, hit), blocked) in rays.iter().zip(&hits).zip(&blocked) {
            assert_eq!(*hit, tracer.closest(ray));
            assert_eq!(*blocked, hit.is_hit());
        }
    }
}
