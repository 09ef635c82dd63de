//! Who refers to accessors and buffer views, and what nobody refers to any more.

use serde_json::Value;

use super::values::{extension_mut, list_mut};

/// Extensions that refer to no accessor and no buffer view, but for those that are visited here.
const KNOWN: [&str; 20] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "GODOT_single_root",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_techniques_webgl",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
    "MSFT_texture_dds",
    "VRMC_materials_mtoon",
];

/// Whether every reference is known, so that lists may be made shorter.
pub(super) fn all_known(value: &Value) -> bool {
    let Value::Object(object) = value else {
        return value.as_array().is_none_or(|list| list.iter().all(all_known));
    };
    object.iter().all(|(key, value)| match (key.as_str(), value) {
        // Data of applications may hold anything; it refers to nothing of the file.
        ("extras", _) => true,
        ("extensions", Value::Object(extensions)) => extensions.iter().all(|(name, value)| {
            let known = KNOWN.contains(&name.as_str()) || name.starts_with("KHR_materials_");
            known && all_known(value)
        }),
        _ => all_known(value),
    })
}

/// Calls `visit` for each value that is the index of an accessor.
pub(super) fn accessors(root: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    for mesh in list_mut(root, "meshes") {
        for primitive in list_mut(mesh, "primitives") {
            for target in list_mut(primitive, "targets") {
                members(Some(target), visit);
            }
            members(primitive.get_mut("attributes"), visit);
            primitive.get_mut("indices").map(&mut *visit);
        }
    }
    for animation in list_mut(root, "animations") {
        for sampler in list_mut(animation, "samplers") {
            sampler.get_mut("input").map(&mut *visit);
            sampler.get_mut("output").map(&mut *visit);
        }
    }
    for skin in list_mut(root, "skins") {
        skin.get_mut("inverseBindMatrices").map(&mut *visit);
    }
    for node in list_mut(root, "nodes") {
        if let Some(instances) = extension_mut(node, "EXT_mesh_gpu_instancing") {
            members(instances.get_mut("attributes"), visit);
        }
    }
}

/// Calls `visit` for each value that is the index of a buffer view.
pub(super) fn views(root: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    for accessor in list_mut(root, "accessors") {
        accessor.get_mut("bufferView").map(&mut *visit);
        if let Some(sparse) = accessor.get_mut("sparse") {
            for part in ["indices", "values"] {
                sparse.get_mut(part).and_then(|p| p.get_mut("bufferView")).map(&mut *visit);
            }
        }
    }
    for image in list_mut(root, "images") {
        image.get_mut("bufferView").map(&mut *visit);
    }
    for mesh in list_mut(root, "meshes") {
        for primitive in list_mut(mesh, "primitives") {
            let draco = extension_mut(primitive, "KHR_draco_mesh_compression");
            draco.and_then(|draco| draco.get_mut("bufferView")).map(&mut *visit);
        }
    }
}

fn members(object: Option<&mut Value>, visit: &mut dyn FnMut(&mut Value)) {
    if let Some(Value::Object(object)) = object {
        object.values_mut().for_each(visit);
    }
}

type Visitor = fn(&mut Value, &mut dyn FnMut(&mut Value));

/// Removes the elements of a top-level list that nobody refers to. Returns the old indices of those
/// that stay.
pub(super) fn sweep(root: &mut Value, key: &str, visitor: Visitor) -> Vec<usize> {
    let count = list_mut(root, key).len();
    let mut place = vec![None; count];
    visitor(root, &mut |index| {
        if let Some(place) = at(index).and_then(|i| place.get_mut(i)) {
            *place = Some(0);
        }
    });
    let kept: Vec<usize> = (0..count).filter(|&i| place[i].is_some()).collect();
    for (new, &old) in kept.iter().enumerate() {
        place[old] = Some(new);
    }
    visitor(root, &mut |index| {
        if let Some(new) = at(index).and_then(|i| place.get(i).copied().flatten()) {
            *index = new.into();
        }
    });
    if let Some(Value::Array(list)) = root.get_mut(key) {
        let mut i = 0;
        list.retain(|_| {
            i += 1;
            place[i - 1].is_some()
        });
    }
    kept
}

fn at(index: &Value) -> Option<usize> {
    index.as_u64().and_then(|i| usize::try_from(i).ok())
}
