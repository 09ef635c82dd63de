//! Small glTF files, put together in memory; the baker's tests make theirs with it too.

#![allow(dead_code, reason = "every test uses its own part")]

use serde_json::{Value, json};

/// A file whose parts can be changed before it is written.
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
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
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
        let range = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..N).filter_map(|k| values.iter().map(|v| v[k]).reduce(pick)).collect()
        };
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5126, "count": values.len(), "type": kind,
                   "min": range(f32::min), "max": range(f32::max)}),
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

    /// Adds an accessor of whole numbers of one byte.
    pub(crate) fn bytes_of(&mut self, values: &[u8], kind: &str, count: usize) -> usize {
        let view = self.view(values);
        let accessor =
            json!({"bufferView": view, "componentType": 5121, "count": count, "type": kind});
        self.push("accessors", accessor)
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
