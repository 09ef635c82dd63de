//! Whether a mesh encloses a volume.

use std::collections::HashMap;

use crate::scene::Mesh;

/// Whether every edge, vertices at equal places taken as one, is used once in each direction by
/// triangles with three distinct corners.
pub(crate) fn is_closed(mesh: &Mesh) -> bool {
    let mut welded = HashMap::with_capacity(mesh.positions.len());
    let weld: Vec<u32> = mesh
        .positions
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let key = p.to_array().map(|v| (v + 0.0).to_bits()); // +0.0: both zeros are one
            *welded.entry(key).or_insert(i as u32)
        })
        .collect();
    let mut balance: HashMap<(u32, u32), i32> = HashMap::with_capacity(mesh.triangles.len() * 2);
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|i| weld[i as usize]);
        if a == b || b == c || c == a {
            continue;
        }
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let edge = balance.entry((from.min(to), from.max(to))).or_default();
            *edge += if from < to { 1 } else { -1 };
        }
    }
    !balance.is_empty() && balance.values().all(|b| *b == 0)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn a_tetrahedron_is_closed_until_a_face_is_missing() {
        let mut mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            ..Default::default()
        };
        assert!(is_closed(&mesh));
        mesh.triangles.pop();
        assert!(!is_closed(&mesh));
        assert!(!is_closed(&Mesh::default()));
    }
}
