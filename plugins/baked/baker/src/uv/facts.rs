//! What decides about a second UV set.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use farlight_gi_solver::{
    import::split_id,
    scene::{InstanceId, Mesh, MeshId},
};
use glam::Affine3A;
use serde_json::Value;

use crate::gltf::{
    Source,
    values::{extension, list, number},
};

/// What is known of a primitive.
pub(super) struct Facts<'a> {
    pub(super) mesh: &'a Mesh,
    /// The vertices of the file that the mesh has, if not all.
    pub(super) vertices: Option<&'a Arc<[u32]>>,
    pub(super) instances: BTreeMap<InstanceId, Affine3A>,
    /// Textures are placed by the second UV set.
    pub(super) fixed: bool,
    pub(super) skinned: bool,
    /// The file's second UV set, if it has one, is stored as floats: others are converted by each reader
    /// in its own way.
    pub(super) floats: bool,
}

/// A primitive in the file.
fn primitive(source: &Source, id: MeshId) -> Option<&Value> {
    let [mesh, primitive] = split_id(id.0);
    let mesh = list(source.json(), "meshes").get(mesh as usize)?;
    list(mesh, "primitives").get(primitive as usize)
}

/// Meshes that skeletons move.
pub(super) fn skinned_meshes(source: &Source) -> BTreeSet<usize> {
    let nodes = list(source.json(), "nodes").iter();
    nodes
        .filter(|node| node.get("skin").is_some())
        .filter_map(|node| node.get("mesh")?.as_u64())
        .map(|mesh| mesh as usize)
        .collect()
}

/// Whether a texture of one of a primitive's materials is read at TEXCOORD_1.
pub(super) fn textures_use_second_set(source: &Source, id: MeshId) -> bool {
    let Some(primitive) = primitive(source, id) else { return false };
    let variants = extension(primitive, "KHR_materials_variants");
    let mappings = variants.map_or(&[][..], |variants| list(variants, "mappings"));
    let own = primitive.get("material").and_then(Value::as_u64);
    let others = mappings.iter().filter_map(|mapping| mapping.get("material")?.as_u64());
    own.into_iter().chain(others).any(|material| {
        list(source.json(), "materials").get(material as usize).is_some_and(reads_second_set)
    })
}

/// Whether a primitive's second UV set is stored as floats.
pub(super) fn second_set_is_float(source: &Source, id: MeshId) -> bool {
    let index = primitive(source, id).and_then(|p| number(p.get("attributes")?, "TEXCOORD_1"));
    let accessor = index.and_then(|i| list(source.json(), "accessors").get(i));
    accessor.and_then(|a| a.get("componentType")?.as_u64()) == Some(5126)
}

fn reads_second_set(material: &Value) -> bool {
    match material {
        Value::Object(object) => object.iter().any(|(key, value)| match key.as_str() {
            "extras" => false,
            "texCoord" => value.as_u64() == Some(1),
            _ => reads_second_set(value),
        }),
        Value::Array(list) => list.iter().any(reads_second_set),
        _ => false,
    }
}
