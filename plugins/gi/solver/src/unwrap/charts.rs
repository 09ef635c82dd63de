//! Charts of an existing second UV set.

use std::collections::HashMap;

use crate::scene::Mesh;

/// Chart of each triangle, numbered from 0 in the order of their first triangles.
///
/// Two triangles are in one chart if they share an edge: the same two positions with the same second
/// UV coordinates. Triangles that touch in a corner only, or that lie side by side in the UV square
/// but not on the surface, are in different charts. Every triangle is its own chart if the mesh has
/// no second UV set.
#[must_use]
pub fn charts(mesh: &Mesh) -> Vec<u32> {
    let count = mesh.triangles.len();
    if mesh.uv1.len() != mesh.positions.len() {
        return (0..count as u32).collect();
    }
    let corners = corner_ids(mesh);
    let mut sets = Sets::new(count);
    let mut first: HashMap<[u32; 2], u32> = HashMap::with_capacity(count * 2);
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let c = triangle.map(|i| corners.get(i as usize).copied().unwrap_or(u32::MAX));
        for [a, b] in [[c[0], c[1]], [c[1], c[2]], [c[2], c[0]]] {
            if a == b {
                continue;
            }
            let other = *first.entry([a.min(b), a.max(b)]).or_insert(t as u32);
            sets.join(other, t as u32);
        }
    }
    let mut names = HashMap::new();
    (0..count as u32)
        .map(|t| {
            let next = names.len() as u32;
            *names.entry(sets.root(t)).or_insert(next)
        })
        .collect()
}

/// The same number for vertices with the same position and second UV coordinates.
fn corner_ids(mesh: &Mesh) -> Vec<u32> {
    let mut ids = HashMap::with_capacity(mesh.positions.len());
    let vertices = mesh.positions.iter().zip(&mesh.uv1);
    vertices
        .map(|(p, uv)| {
            // Adding 0 turns -0 into 0.
            let key = [p.x, p.y, p.z, uv.x, uv.y].map(|v| (v + 0.0).to_bits());
            let next = ids.len() as u32;
            *ids.entry(key).or_insert(next)
        })
        .collect()
}

/// Disjoint sets of triangles.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    pub(super) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    pub(super) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        // The smaller number wins: a set is named by its first triangle.
        self.0[a.max(b) as usize] = a.min(b);
    }

    pub(super) fn root(&mut self, mut t: u32) -> u32 {
        while self.0[t as usize] != t {
            let above = self.0[self.0[t as usize] as usize];
            self.0[t as usize] = above;
            t = above;
        }
        t
    }

    pub(super) fn count(&self) -> u32 {
        (0..self.0.len() as u32).filter(|&t| self.0[t as usize] == t).count() as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    fn mesh(corners: &[([f32; 3], [f32; 2])], triangles: &[[u32; 3]]) -> Mesh {
        Mesh {
            positions: corners.iter().map(|c| Vec3::from(c.0)).collect(),
            uv1: corners.iter().map(|c| Vec2::from(c.1)).collect(),
            triangles: triangles.to_vec(),
            ..Default::default()
        }
    }

    #[test]
    fn split_vertices_with_equal_coordinates_stay_together() {
        // A quad whose triangles do not share indices, and a third triangle that only touches.
        let corners = [
            ([0.0, 0.0, 0.0], [0.0, 0.0]),
            ([1.0, 0.0, 0.0], [0.5, 0.0]),
            ([1.0, 1.0, 0.0], [0.5, 0.5]),
            ([0.0, 0.0, 0.0], [-0.0, 0.0]),
            ([1.0, 1.0, 0.0], [0.5, 0.5]),
            ([0.0, 1.0, 0.0], [0.0, 0.5]),
            ([1.0, 1.0, 0.0], [0.5, 0.5]),
            ([2.0, 1.0, 0.0], [1.0, 0.5]),
            ([2.0, 2.0, 0.0], [1.0, 1.0]),
        ];
        let mesh = mesh(&corners, &[[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
        assert_eq!(charts(&mesh), [0, 0, 1]);
    }

    #[test]
    fn neighbours_in_the_square_but_not_on_the_surface_are_apart() {
        let corners = [
            ([0.0, 0.0, 0.0], [0.0, 0.0]),
            ([1.0, 0.0, 0.0], [0.5, 0.0]),
            ([1.0, 1.0, 0.0], [0.5, 0.5]),
            ([7.0, 0.0, 0.0], [0.0, 0.0]),
            ([7.0, 1.0, 0.0], [0.5, 0.5]),
            ([7.0, 1.0, 1.0], [0.0, 0.5]),
        ];
        let mesh = mesh(&corners, &[[0, 1, 2], [3, 4, 5]]);
        assert_eq!(charts(&mesh), [0, 1]);
    }

    #[test]
    fn long_chains_join_in_any_order() {
        let n = 200_u32;
        let corners: Vec<_> = (0..=n)
            .flat_map(|i| {
                let s = i as f32 / n as f32;
                [([s, 0.0, 0.0], [s, 0.0]), ([s, 1.0, 0.0], [s, 1.0])]
            })
            .collect();
        let mut triangles: Vec<_> = (0..n)
            .flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]])
            .collect();
        // Even places first, so that pieces grow apart and join late.
        triangles.sort_by_key(|t| (t[0] / 2 % 2, t[0]));
        assert!(charts(&mesh(&corners, &triangles)).iter().all(|&c| c == 0));
    }
}
