//! No ray gets out of a closed surface, however exactly it is aimed at a seam.

use std::collections::HashMap;

use glam::{Quat, Vec3};

use super::{Random, tracers};
use crate::tracer::Ray;

/// Corners and triangles that share them.
struct Mesh {
    corners: Vec<Vec3>,
    triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// A sphere of radius 1 from an icosahedron, each triangle cut in four several times.
    fn icosphere(subdivisions: usize) -> Self {
        let g = (1.0 + 5.0f32.sqrt()) / 2.0;
        let mut corners = Vec::new();
        for (a, b) in [(1.0, g), (1.0, -g), (-1.0, g), (-1.0, -g)] {
            corners.extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)]);
        }
        // Neighbours are 2 apart, everything else is further.
        let near = |a: Vec3, b: Vec3| (a.distance(b) - 2.0).abs() < 0.1;
        let mut triangles = Vec::new();
        for a in 0..12 {
            for b in a + 1..12 {
                for c in b + 1..12 {
                    let (p, q, r) = (corners[a], corners[b], corners[c]);
                    if near(p, q) && near(q, r) && near(r, p) {
                        triangles.push([a, b, c]);
                    }
                }
            }
        }
        assert_eq!(triangles.len(), 20);
        corners.iter_mut().for_each(|p| *p = p.normalize());
        for _ in 0..subdivisions {
            let mut middles = HashMap::new();
            let mut middle = |a: usize, b: usize| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    corners.push(((corners[a] + corners[b]) / 2.0).normalize());
                    corners.len() - 1
                })
            };
            triangles = triangles
                .iter()
                .flat_map(|&[a, b, c]| {
                    let (x, y, z) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
                })
                .collect();
        }
        Self { corners, triangles }
    }

    /// A cube from -1 to 1 whose faces are grids of irregular triangles.
    fn cube(n: usize, random: &mut Random) -> Self {
        let mut corners: Vec<Vec3> = Vec::new();
        let mut index = HashMap::new();
        let mut triangles = Vec::new();
        for (axis, side) in [(0, 0), (0, n), (1, 0), (1, n), (2, 0), (2, n)] {
            let mut at = |u: usize, v: usize| {
                let mut key = [side; 3];
                (key[(axis + 1) % 3], key[(axis + 2) % 3]) = (u, v);
                *index.entry(key).or_insert_with(|| {
                    let mut p = [0.0; 3];
                    for a in 0..3 {
                        let inner = key[a] != 0 && key[a] != n;
                        let shift = if inner { random.unit() * 0.8 - 0.4 } else { 0.0 };
                        p[a] = (key[a] as f32 + shift) / n as f32 * 2.0 - 1.0;
                    }
                    corners.push(Vec3::from_array(p));
                    corners.len() - 1
                })
            };
            for u in 0..n {
                for v in 0..n {
                    let [a, b, c, d] = [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)];
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        Self { corners, triangles }
    }

    fn map(mut self, f: impl Fn(Vec3) -> Vec3) -> Self {
        self.corners.iter_mut().for_each(|p| *p = f(*p));
        self
    }

    fn triangles(&self) -> Vec<[Vec3; 3]> {
        self.triangles.iter().map(|t| t.map(|i| self.corners[i])).collect()
    }
}

/// Shoots at corners and at points of edges from `origins`.
fn assert_closed(name: &str, mesh: &Mesh, origins: &[Vec3], rays: usize) {
    let mut random = Random(11);
    let triangles = mesh.triangles();
    let tracers = tracers(&triangles);
    for i in 0..rays {
        let origin = origins[i % origins.len()];
        let [a, b, _] = triangles[random.word() as usize % triangles.len()];
        let target = match i % 3 {
            0 => a,
            1 => (a + b) / 2.0,
            _ => a + random.unit() * (b - a),
        };
        let ray = Ray::new(origin, target - origin);
        if ray.direction == Vec3::ZERO {
            continue;
        }
        for tracer in &tracers {
            let kernel = tracer.instructions;
            assert!(tracer.closest(&ray).is_hit(), "{name}, {kernel:?}: {ray:?} gets out");
            assert!(tracer.occluded(&ray), "{name}, {kernel:?}: {ray:?} gets out");
        }
    }
}

#[test]
fn spheres_keep_rays_in() {
    let mut random = Random(5);
    let mut inside: Vec<Vec3> = (0..99).map(|_| random.cube() * 0.5).collect();
    inside.push(Vec3::ZERO);
    let mesh = Mesh::icosphere(5);
    assert_closed("sphere", &mesh, &inside, 150_000);
    for (name, scale, centre) in [
        ("far away", 1.0, Vec3::new(1000.0, -300.0, 70.0)),
        ("tiny", 1.0e-4, Vec3::ZERO),
        ("large", 3.0e6, Vec3::new(5.0, 0.0, 0.0)),
    ] {
        let mesh = Mesh::icosphere(4).map(|p| p * scale + centre);
        let inside: Vec<Vec3> = inside.iter().map(|&p| p * scale + centre).collect();
        assert_closed(name, &mesh, &inside, 60_000);
    }
}

#[test]
fn boxes_keep_rays_in() {
    let mut random = Random(6);
    // On the walls' grid lines, too: axis-parallel rays in the plane of box faces.
    let mut inside: Vec<Vec3> = (0..60).map(|_| random.cube() * 0.9).collect();
    inside.extend((0..40).map(|i| Vec3::new(i as f32 / 20.0 - 1.0, 0.0, 0.5) * 0.5));
    let mesh = Mesh::cube(24, &mut random);
    assert_closed("box", &mesh, &inside, 100_000);
    let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let place = |p: Vec3| turn * (p * Vec3::new(40.0, 0.02, 3.0)) + Vec3::new(7.0, 80.0, -9.0);
    let inside: Vec<Vec3> = inside.iter().map(|&p| place(p * 0.5)).collect();
    assert_closed("flat box", &mesh.map(place), &inside, 100_000);
}

#[test]
fn axis_parallel_rays_hit_the_seams_of_a_grid() {
    let mut triangles = Vec::new();
    let n = 32;
    for i in 0..n {
        for j in 0..n {
            let at = |i: i32, j: i32| Vec3::new(i as f32 / 8.0, 3.0, j as f32 / 8.0);
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for tracer in tracers(&triangles) {
        for i in 0..=2 * n {
            for j in 0..=2 * n {
                let from = Vec3::new(i as f32 / 16.0, 0.0, j as f32 / 16.0);
                for direction in [Vec3::Y, Vec3::new(0.0, 1.0, -0.0), Vec3::new(-0.0, 2.0, 0.0)] {
                    let hit = tracer.closest(&Ray::new(from, direction));
                    assert!(hit.is_hit(), "{from} {:?}", tracer.instructions);
                    assert!((hit.t * direction.y - 3.0).abs() < 1e-5);
                }
            }
        }
    }
}
