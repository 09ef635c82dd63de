//! Small files that the importer reads.

use std::f64::consts::FRAC_1_SQRT_2;

use serde_json::json;

pub(crate) use crate::builder::{Glb, SQUARE, write};

/// Its two triangles.
pub(crate) const SQUARE_INDICES: [u32; 6] = [0, 1, 2, 0, 2, 3];

/// A square with indices.
pub(crate) fn square() -> Glb {
    let mut glb = Glb::new();
    let position = glb.floats(&SQUARE);
    let indices = glb.indices(&SQUARE_INDICES);
    glb.mesh(json!({"attributes": {"POSITION": position}, "indices": indices}));
    glb
}

/// A PNG of `width` x `height` pixels, all of one colour.
pub(crate) fn png(width: u32, height: u32, color: [u8; 4]) -> Vec<u8> {
    let image = image::RgbaImage::from_pixel(width, height, image::Rgba(color));
    let mut bytes = Vec::new();
    image.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).expect("a PNG");
    bytes
}

/// A file with a bit of everything that the importer reads.
pub(crate) fn rich() -> Glb {
    let mut glb = Glb::new();
    let position = glb.floats(&SQUARE);
    let normal = glb.floats(&[[0.0, 0.0, 1.0]; 4]);
    let uv = glb.floats(&SQUARE.map(|p| [p[0], p[1]]));
    let indices = glb.indices(&SQUARE_INDICES);
    // Interleaved 16-bit positions with a sparse replacement of the last one.
    let mut bytes = Vec::new();
    for p in [[0_u16, 0, 0], [9, 0, 0], [9, 9, 0], [0, 0, 0]] {
        bytes.extend(p.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    let view = glb.view(&bytes);
    glb.json["bufferViews"][view]["byteStride"] = 8.into();
    let places = glb.view(&[3]);
    let values = glb.view(&[0, 0, 9, 0, 0, 0]);
    let quantized = glb.push(
        "accessors",
        json!({"bufferView": view, "componentType": 5123, "count": 4, "type": "VEC3", "sparse": {
            "count": 1, "indices": {"bufferView": places, "componentType": 5121},
            "values": {"bufferView": values}}}),
    );
    let bytes: Vec<u8> = [0_u16, 1, 2, 3].iter().flat_map(|v| v.to_le_bytes()).collect();
    let view = glb.view(&bytes);
    let strip = glb.push(
        "accessors",
        json!({"bufferView": view, "componentType": 5123, "count": 4, "type": "SCALAR"}),
    );
    let image = glb.view(&png(5, 3, [200, 100, 50, 255]));
    glb.json["images"] = json!([{"bufferView": image, "mimeType": "image/png"}]);
    glb.json["samplers"] = json!([{"wrapS": 10497}]);
    glb.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    let placed = json!({"index": 0, "extensions": {"KHR_texture_transform": {
        "offset": [0.5, 0.0], "scale": [2.0, 3.0]}}});
    glb.json["materials"] = json!([
        {"name": "lamp", "emissiveFactor": [1.0, 0.5, 0.25], "emissiveTexture": {"index": 0},
         "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8.0}}},
        {"name": "cloth", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
         "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.6, 0.7, 0.8], "metallicFactor": 0.25,
            "roughnessFactor": 0.75, "metallicRoughnessTexture": placed, "baseColorTexture": placed}},
    ]);
    let first = json!({
        "attributes": {"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv, "TEXCOORD_1": uv},
        "indices": indices, "material": 0, "mode": 4});
    let second = json!({"attributes": {"POSITION": quantized}, "indices": strip, "mode": 5,
                        "material": 1});
    glb.push("meshes", json!({"name": "pair", "primitives": [first, second]}));
    let child = glb.push("nodes", json!({"name": "child", "mesh": 0, "scale": [-2.0, 1.0, 1.0]}));
    glb.node(json!({"name": "parent", "translation": [1.0, 2.0, 3.0], "children": [child],
        "rotation": [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2]}));
    glb.json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_mesh_quantization"]);
    glb.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "intensity": 4.0, "color": [1.0, 0.5, 0.25], "range": 7.0},
        {"type": "spot", "intensity": 2.0, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}},
        {"type": "directional"},
    ]}});
    for light in [2, 0, 1] {
        glb.node(json!({"extensions": {"KHR_lights_punctual": {"light": light}},
                        "translation": [0.0, light, 0.0],
                        "rotation": [-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]}));
    }
    glb
}
