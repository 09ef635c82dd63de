//! Small files that have what a lit scene must keep.

use serde_json::json;

pub(crate) use crate::builder::{Glb, SQUARE, write};

/// The first bytes of a PNG are enough for what does not decode it.
pub(crate) const PNG: &[u8] = b"\x89PNG\r\n\x1a\n, in spirit";

/// A bit of everything: interleaved attributes with gaps, a sparse accessor, indices of one byte, a
/// strip, lines, morph targets, a custom attribute, shared meshes, one of them mirrored, a skin, an animation, a
/// camera, lights, an image, extras of all kinds, data that nobody uses.
pub(crate) fn rich() -> Glb {
    let mut glb = Glb::new();
    glb.json["asset"]["generator"] = "a test".into();
    glb.json["scenes"][0]["name"] = "all".into();
    glb.view(&[7; 64]);
    // Position, normal, colour of three bytes with one of padding, interleaved; two vertices are unused.
    let places = [SQUARE.as_slice(), &[[5.0, 5.0, 5.0], [f32::NAN; 3]]].concat();
    let mut bytes = Vec::new();
    for (i, p) in places.iter().enumerate() {
        bytes.extend(p.iter().chain(&[0.0, 0.0, 1.0]).flat_map(|v| v.to_le_bytes()));
        bytes.extend([i as u8, 10, 20, 99]);
    }
    let view = glb.view(&bytes);
    glb.json["bufferViews"][view]["byteStride"] = 28.into();
    let mut part = |offset: u32, component: u32, normalized: bool, name: &str| {
        let accessor = json!({"bufferView": view, "byteOffset": offset, "componentType": component,
            "normalized": normalized, "count": 6, "type": "VEC3", "name": name});
        glb.push("accessors", accessor)
    };
    let (position, normal) = (part(0, 5126, false, "places"), part(12, 5126, false, "normals"));
    let color = part(24, 5121, true, "colours");
    glb.json["accessors"][position]["min"] = json!([0, 0, 0]);
    glb.json["accessors"][position]["max"] = json!([5, 5, 5]);
    let uv =
        glb.floats(&[[0.0_f32, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0], [9.0, 9.0], [9.0, 9.0]]);
    let custom = glb.bytes_of(&[0, 1, 2, 3, 4, 5], "SCALAR", 6);
    let indices = glb.bytes_of(&[0, 1, 2, 0, 2, 3, 0, 0, 1], "SCALAR", 9);
    // A target that moves the third vertex only.
    let (at, to) =
        (glb.view(&[2, 0, 0, 0]), glb.view(&[0.0_f32, 0.0, 2.0].map(f32::to_le_bytes).concat()));
    let target = glb.push(
        "accessors",
        json!({"componentType": 5126, "count": 6, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 2],
            "sparse": {"count": 1, "indices": {"bufferView": at, "componentType": 5121},
                       "values": {"bufferView": to}}}),
    );
    let strip_places = glb.floats(&SQUARE.map(|p| [p[0] + 2.0, p[1] * 2.0, 0.0]));
    let strip_normals = glb.floats(&[[0.0_f32, 0.0, 1.0]; 4]);
    let strip = glb.bytes_of(&[0, 1, 3, 2], "SCALAR", 4);
    let lines = glb.bytes_of(&[0, 1, 1, 2], "SCALAR", 4);
    let first = json!({
        "attributes": {"POSITION": position, "NORMAL": normal, "COLOR_0": color, "TEXCOORD_0": uv,
                       "_CUSTOM": custom},
        "indices": indices, "material": 0, "targets": [{"POSITION": target}],
        "extras": {"kept": true}});
    let second = json!({"attributes": {"POSITION": strip_places, "NORMAL": strip_normals},
        "indices": strip, "mode": 5, "material": 1});
    let third = json!({"attributes": {"POSITION": strip_places}, "indices": lines, "mode": 1});
    glb.push(
        "meshes",
        json!({"name": "both", "primitives": [first, second, third],
        "weights": [0.5], "extras": {"targetNames": ["up"]}}),
    );
    let image = glb.view(PNG);
    glb.json["images"] = json!([{"bufferView": image, "mimeType": "image/png", "name": "picture"}]);
    glb.json["samplers"] = json!([{"wrapS": 10497}]);
    glb.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    glb.json["materials"] = json!([
        {"name": "wood", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
         "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5}}},
        {"name": "lamp", "emissiveFactor": [1.0, 0.5, 0.25]},
    ]);
    let child =
        glb.push("nodes", json!({"name": "mirrored", "mesh": 0, "scale": [-2.0, 1.0, 1.0]}));
    glb.node(json!({"name": "parent", "translation": [1.0, 2.0, 3.0], "children": [child]}));
    let moved = glb.node(json!({"name": "plain", "mesh": 0, "extras": {"mine": 1}}));
    glb.json["cameras"] = json!([{"type": "perspective",
        "perspective": {"yfov": 0.7, "znear": 0.1}}]);
    glb.node(json!({"name": "eye", "camera": 0, "extras": "a word"}));
    glb.node(json!({"name": "light", "translation": [0.0, 3.0, 0.0], "extras": "a word",
        "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    glb.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "intensity": 4.0, "range": 7.0}, {"type": "directional"}]}});
    let times = glb.floats(&[[0.0_f32], [1.0]]);
    let ways = glb.floats(&[[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    glb.json["animations"] = json!([{"channels": [{"sampler": 0,
        "target": {"node": moved, "path": "translation"}}],
        "samplers": [{"input": times, "output": ways}]}]);
    glb.json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_clearcoat"]);
    glb
}
