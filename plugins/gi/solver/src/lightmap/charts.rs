//! Charts of the second UV set.

use std::collections::HashMap;

use crate::scene::Mesh;

/// The chart of each triangle: triangles are in one chart if they share an edge in space and in the
/// second UV set. Charts are numbered by their first triangle.
pub(crate) fn charts(mesh: &Mesh) -> Vec<u32> {
    // Vertices with equal position and UV are one, whatever their index.
    let mut welded = HashMap::with_capacity(mesh.positions.len());
    let weld: Vec<u32> = mesh
        .positions
        .iter()
        .zip(&mesh.uv1)
        .enumerate()
        .map(|(i, (p, uv))| {
            let bits = |v: f32| (v + 0.0).to_bits(); // +0.0: both zeros are one
            let key = [p.x, p.y, p.z, uv.x, uv.y].map(bits);
            *welded.entry(key).or_insert(i as u32)
        })
        .collect();
    let mut parent: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    let mut edges = HashMap::with_capacity(mesh.triangles.len() * 2);
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (weld[corners[i] as usize], weld[corners[(i + 1) % 3] as usize]);
            let other = *edges.entry((a.min(b), a.max(b))).or_insert(triangle as u32);
            let (a, b) = (root(&mut parent, triangle as u32), root(&mut parent, other));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    (0..parent.len() as u32).map(|t| root(&mut parent, t)).collect()
}

fn root(parent: &mut [u32], mut t: u32) -> u32 {
    while parent[t as usize] != t {
        parent[t as usize] = parent[parent[t as usize] as usize];
        t = parent[t as usize];
    }
    t
}
