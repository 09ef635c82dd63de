//! Tangents of a mesh that has none: means over its triangles, so that highlights of cloth run
//! smoothly over it.

use bevy::{
    mesh::{PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};

/// Adds tangents along growing u. Leaves alone a mesh that has some, or that lacks what is needed.
pub fn add(mesh: &mut Mesh) {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList
        || mesh.contains_attribute(Mesh::ATTRIBUTE_TANGENT)
    {
        return;
    }
    let vectors = |attribute| match mesh.attribute(attribute) {
        Some(VertexAttributeValues::Float32x3(values)) => Some(values),
        _ => None,
    };
    let (positions, normals) =
        (vectors(Mesh::ATTRIBUTE_POSITION.id), vectors(Mesh::ATTRIBUTE_NORMAL.id));
    let Some(VertexAttributeValues::Float32x2(uvs)) = mesh.attribute(Mesh::ATTRIBUTE_UV_0) else {
        return;
    };
    let (Some(positions), Some(normals)) = (positions, normals) else { return };
    let indices: Vec<usize> = match mesh.indices() {
        Some(indices) => indices.iter().collect(),
        None => (0..positions.len()).collect(),
    };
    let mut sums = vec![(Vec3::ZERO, 0.0); positions.len()];
    for triangle in indices.chunks_exact(3) {
        let &[a, b, c] = triangle else { continue };
        if [a, b, c].iter().any(|&i| i >= positions.len().min(normals.len()).min(uvs.len())) {
            continue;
        }
        let p = [a, b, c].map(|i| Vec3::from(positions[i]));
        let uv = [a, b, c].map(|i| Vec2::from(uvs[i]));
        let (e, f) = (p[1] - p[0], p[2] - p[0]);
        let (du, dv) = (uv[1] - uv[0], uv[2] - uv[0]);
        let area = du.perp_dot(dv);
        let along = (e * dv.y - f * du.y) * area.signum();
        for i in [a, b, c] {
            sums[i].0 += along;
            sums[i].1 += area;
        }
    }
    let tangents: Vec<[f32; 4]> = sums
        .iter()
        .zip(normals)
        .map(|(&(sum, area), normal)| {
            let normal = Vec3::from(*normal);
            let fallback = normal.any_orthonormal_vector();
            let tangent = (sum - normal * normal.dot(sum)).normalize_or(fallback);
            // v runs down: with u to the right the area of a front face is negative.
            tangent.extend(if area > 0.0 { -1.0 } else { 1.0 }).to_array()
        })
        .collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, tangents);
}
