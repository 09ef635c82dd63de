//! Small glTF files, put together in memory.

use std::f64::consts::FRAC_1_SQRT_2;

use serde_json::{Value, json};

/// A file whose parts can be spoiled before it is written.
#[derive(Clone)]
pub(crate) struct Glb {
    /// The JSON chunk.
    pub(crate) json: Value,
    /// The binary chunk.
    pub(crate) bin: Vec<u8>,
}

impl Glb {
    /// A file with an empty scene.
    pub(crate) fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
            "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}],
        });
        Self { json, bin: Vec::new() }
    }

    /// Adds an element to a top-level list; its index.
    pub(crate) fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Adds a buffer view.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()});
        self.bin.extend(bytes);
        self.json["buffers"][0]["byteLength"] = self.bin.len().into();
        self.push("bufferViews", view)
    }

    /// Adds an accessor of floats.
    pub(crate) fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5126, "count": values.len(), "type": kind}),
        )
    }

    /// Adds an accessor of 32-bit indices.
    pub(crate) fn indices(&mut self, values: &[u32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5125, "count": values.len(),
                   "type": "SCALAR"}),
        )
    }

    /// Adds a mesh of one primitive and a root node for it; the node's index.
    pub(crate) fn mesh(&mut self, primitive: Value) -> usize {
        let mesh = self.push("meshes", json!({"primitives": [primitive]}));
        self.node(json!({"mesh": mesh}))
    }

    /// Adds a root node.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let node = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("a list").push(node.into());
        node
    }

    /// The file.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        write(self.json.to_string().as_bytes(), &self.bin)
    }
}

/// Header and chunks.
pub(crate) fn write(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let padded = |data: &[u8], with: u8| {
        let mut data = data.to_vec();
        data.resize(data.len().next_multiple_of(4), with);
        data
    };
    let (json, bin) = (padded(json, b' '), padded(bin, 0));
    let word = |v: usize| (v as u32).to_le_bytes();
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend(word(28 + json.len() + bin.len()));
    for (tag, data) in [(b"JSON", json), (b"BIN\0", bin)] {
        glb.extend(word(data.len()));
        glb.extend(tag);
        glb.extend(data);
    }
    glb
}

/// Positions of a unit square in the xy plane.
pub(crate) const SQUARE: [[f32; 3]; 4] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

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
