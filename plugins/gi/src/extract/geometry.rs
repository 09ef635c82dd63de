//! Triangles of Bevy's meshes, and second UV sets for those that have none.

use std::sync::{Arc, atomic::AtomicBool};

use bevy::{
    math::{Vec2, Vec3},
    mesh::{Indices, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues},
    prelude::Mesh,
};
use farlight_gi_solver::{scene, unwrap::Unwrapped};

use crate::uv1::second_uv_set;

/// What a task makes of a mesh.
pub(super) struct Converted {
    /// Its triangles for the solver.
    pub(super) geometry: Arc<scene::Mesh>,
    /// A mesh to draw instead, with a second UV set.
    pub(super) replacement: Option<Box<Mesh>>,
    /// Why it can't receive light, if so.
    pub(super) no_receiver: Option<String>,
}

/// Converts a mesh, making a second UV set where there is no usable one, until `stop` is set.
pub(super) fn convert(
    mesh: &Mesh,
    texels_per_metre: f32,
    stop: &AtomicBool,
) -> Result<Converted, String> {
    let mut geometry = triangles(mesh)?;
    geometry.validate().map_err(|problem| problem.to_string())?;
    let (replacement, no_receiver) = match second_uv_set(&geometry, texels_per_metre, stop) {
        Ok(unwrapped) if unwrapped.made.is_none() => (None, None),
        Ok(unwrapped) => {
            let replacement = rebuild(mesh, &unwrapped)?;
            geometry = unwrapped.apply(&geometry);
            (Some(Box::new(replacement)), None)
        }
        Err(reason) => {
            geometry.uv1.clear();
            (None, Some(reason))
        }
    };
    Ok(Converted { geometry: Arc::new(geometry), replacement, no_receiver })
}

/// Positions, normals, UV sets and triangles of a mesh.
fn triangles(mesh: &Mesh) -> Result<scene::Mesh, String> {
    let positions = match attribute(mesh, Mesh::ATTRIBUTE_POSITION)? {
        Some(VertexAttributeValues::Float32x3(values)) => {
            values.iter().copied().map(Vec3::from_array).collect::<Vec<_>>()
        }
        Some(_) => return Err("its positions aren't three 32-bit floats".into()),
        None => return Err("it has no positions".into()),
    };
    let normals = match attribute(mesh, Mesh::ATTRIBUTE_NORMAL)? {
        Some(VertexAttributeValues::Float32x3(values)) => {
            values.iter().copied().map(Vec3::from_array).collect()
        }
        _ => Vec::new(),
    };
    let uv = |set| -> Result<Vec<Vec2>, String> {
        Ok(match attribute(mesh, set)? {
            Some(VertexAttributeValues::Float32x2(values)) => {
                values.iter().copied().map(Vec2::from_array).collect()
            }
            _ => Vec::new(),
        })
    };
    let indices: Vec<u32> = match mesh.try_indices_option().map_err(|_| no_data())? {
        Some(Indices::U16(indices)) => indices.iter().map(|&i| u32::from(i)).collect(),
        Some(Indices::U32(indices)) => indices.clone(),
        None => {
            (0..u32::try_from(positions.len()).map_err(|_| "it has too many vertices")?).collect()
        }
    };
    let triangles = match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => indices.as_chunks::<3>().0.to_vec(),
        PrimitiveTopology::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .filter(|[a, b, c]| a != b && b != c && a != c)
            .collect(),
        PrimitiveTopology::LineList | PrimitiveTopology::LineStrip => {
            return Err("it consists of lines".into());
        }
        PrimitiveTopology::PointList => return Err("it consists of points".into()),
    };
    let (uv0, uv1) = (uv(Mesh::ATTRIBUTE_UV_0)?, uv(Mesh::ATTRIBUTE_UV_1)?);
    let mut mesh = scene::Mesh { positions, normals, uv0, uv1, triangles };
    make_finite(&mut mesh);
    Ok(mesh)
}

/// Exporters write NaN for the normals and the UVs of triangles without area. Those are not worth
/// leaving a mesh out.
fn make_finite(mesh: &mut scene::Mesh) {
    mesh.normals.iter_mut().filter(|n| !n.is_finite()).for_each(|n| *n = Vec3::Y);
    mesh.uv0.iter_mut().filter(|uv| !uv.is_finite()).for_each(|uv| *uv = Vec2::ZERO);
    if !mesh.uv1.iter().all(|uv| uv.is_finite()) {
        // One is made.
        mesh.uv1.clear();
    }
}

fn attribute(
    mesh: &Mesh,
    attribute: MeshVertexAttribute,
) -> Result<Option<&VertexAttributeValues>, String> {
    mesh.try_attribute_option(attribute).map_err(|_| no_data())
}

/// The reason for meshes that only the GPU has.
pub(super) fn no_data() -> String {
    "its data isn't on the CPU; load it with RenderAssetUsages::MAIN_WORLD | RENDER_WORLD".into()
}

fn pick<T: Copy>(values: &[T], source: &[u32]) -> Vec<T> {
    if values.is_empty() {
        return Vec::new();
    }
    source.iter().map(|&i| values[i as usize]).collect()
}

/// The mesh with its vertices split where the second UV set has seams; all attributes carry over.
fn rebuild(mesh: &Mesh, unwrapped: &Unwrapped) -> Result<Mesh, String> {
    let mut made = Mesh::new(PrimitiveTopology::TriangleList, mesh.asset_usage);
    for (attribute, values) in mesh.try_attributes().map_err(|_| no_data())? {
        if attribute.id != Mesh::ATTRIBUTE_UV_1.id {
            made.insert_attribute(*attribute, gather(values, &unwrapped.source));
        }
    }
    let uv1: Vec<[f32; 2]> = unwrapped.uv1.iter().map(Vec2::to_array).collect();
    made.insert_attribute(Mesh::ATTRIBUTE_UV_1, uv1);
    made.insert_indices(Indices::U32(unwrapped.triangles.as_flattened().to_vec()));
    made.enable_raytracing = mesh.enable_raytracing;
    Ok(made)
}

macro_rules! gather_each {
    ($values:expr, $source:expr; $($kind:ident)*) => {
        match $values {
            $(VertexAttributeValues::$kind(v) => VertexAttributeValues::$kind(pick(v, $source)),)*
        }
    };
}

fn gather(values: &VertexAttributeValues, source: &[u32]) -> VertexAttributeValues {
    gather_each!(values, source;
        Uint8 Uint8x2 Uint8x4 Sint8 Sint8x2 Sint8x4 Unorm8 Unorm8x2 Unorm8x4 Snorm8
        Snorm8x2 Snorm8x4 Uint16 Uint16x2 Uint16x4 Sint16 Sint16x2 Sint16x4 Unorm16
        Unorm16x2 Unorm16x4 Snorm16 Snorm16x2 Snorm16x4 Float16 Float16x2 Float16x4
        Float32 Float32x2 Float32x3 Float32x4 Uint32 Uint32x2 Uint32x3 Uint32x4 Sint32
        Sint32x2 Sint32x3 Sint32x4 Float64 Float64x2 Float64x3 Float64x4 Unorm10_10_10_2 Unorm8x4Bgra
    )
}

#[cfg(test)]
mod tests {
    use bevy::asset::RenderAssetUsages;

    use super::*;

    #[test]
    fn attributes_that_are_not_finite_are_replaced() {
        let usage = RenderAssetUsages::default();
        let positions = vec![[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, usage)
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[f32::NAN, 0.0, 1.0]; 3])
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[f32::INFINITY, 0.0]; 3])
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, vec![[0.0, f32::NAN]; 3]);
        let made = triangles(&mesh).unwrap();
        assert_eq!((made.normals, made.uv0), (vec![Vec3::Y; 3], vec![Vec2::ZERO; 3]));
        assert!(made.uv1.is_empty());
    }
}
