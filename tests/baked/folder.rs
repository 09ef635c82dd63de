//! Folders as a bake writes them, made by hand.

use std::path::PathBuf;

use bevy::prelude::*;
use farlight::baked::format::{
    Fingerprint, Manifest, ktx2,
    manifest::{Page, Receiver, Scenario, VERSION, Volume},
};
use serde_json::{Value, json};

/// Edge of the pages in texels: rows of half floats are 256 bytes.
pub(crate) const PAGE: u32 = 32;

/// The first quad's place on its page.
pub(crate) const RECT: [u32; 4] = [0, 0, 16, 16];

/// The second UV set of all quads.
pub(crate) const UV: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// A folder that disappears when a test makes it anew.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new(test: &str) -> Self {
        let path = crate::support::scratch("baked").join(test);
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.0.join(name), bytes).unwrap();
    }

    /// `room.glb`: a matte grey square of two metres that faces +z at each place, and a node with each
    /// light (`KHR_lights_punctual`) at the origin. Nodes are counted in this order.
    pub(crate) fn scene(&self, places: &[Vec3], lights: &[Value]) {
        self.write("room.glb", glb(places, lights, UV));
    }

    /// A page of one scenario.
    pub(crate) fn page(&self, name: &str, texel: impl Fn(u32, u32) -> Vec3) {
        let texels: Vec<_> = (0..PAGE).flat_map(|y| (0..PAGE).map(move |x| (x, y))).collect();
        let texels: Vec<_> = texels.into_iter().map(|(x, y)| texel(x, y)).collect();
        self.write(name, ktx2::lightmap_page(PAGE, PAGE, &texels));
    }

    /// A volume of one probe with these faces: +x, -x, +y, -y, +z, -z.
    pub(crate) fn volume(&self, name: &str, faces: [Vec3; 6]) {
        self.write(name, ktx2::volume(UVec3::ONE, &[faces]));
    }

    pub(crate) fn manifest(&self, manifest: &Manifest) {
        self.write("room.baked.ron", manifest.to_text());
    }

    /// A scene of one square and a manifest of scenarios, each with a page of one colour.
    pub(crate) fn square(test: &str, scenarios: &[(&str, Vec3)]) -> (Self, Manifest) {
        let folder = Self::new(test);
        folder.scene(&[Vec3::ZERO], &[]);
        for (name, texel) in scenarios {
            folder.page(&format!("{name}.0.ktx2"), |_, _| *texel);
        }
        let names: Vec<_> = scenarios.iter().map(|(name, _)| *name).collect();
        let manifest = manifest(&[receiver(0)], &names);
        folder.manifest(&manifest);
        (folder, manifest)
    }
}

/// What is lit of a node.
pub(crate) fn receiver(node: u32) -> Receiver {
    Receiver {
        node,
        primitive: 0,
        name: format!("square {node}"),
        page: 0,
        rect: RECT,
        uv: Fingerprint::of_uv(UV.map(Vec2::from)),
    }
}

/// A manifest with one page, `NAME.0.ktx2` of each scenario.
pub(crate) fn manifest(receivers: &[Receiver], scenarios: &[&str]) -> Manifest {
    let scenario = |name: &&str| Scenario {
        name: (*name).into(),
        pages: vec![Page { ktx2: format!("{name}.0.ktx2"), exr: String::new() }],
        samples: 1,
        ..Scenario::default()
    };
    Manifest {
        version: VERSION,
        scene: "room.glb".into(),
        complete: true,
        page_size: PAGE,
        pages: 1,
        receivers: receivers.to_vec(),
        scenarios: scenarios.iter().map(scenario).collect(),
        ..Manifest::default()
    }
}

/// A box of one probe around a place.
pub(crate) fn volume(at: Vec3, size: f32) -> Volume {
    let transform = Transform::from_translation(at).with_scale(Vec3::splat(size));
    Volume::new(&transform.compute_affine(), UVec3::ONE)
}

/// The bytes of the scene.
pub(crate) fn glb(places: &[Vec3], lights: &[Value], uv1: [[f32; 2]; 4]) -> Vec<u8> {
    let mut bin = Vec::new();
    let mut views = Vec::new();
    let mut view = |floats: &[f32]| {
        views.push(json!({"buffer": 0, "byteOffset": bin.len(), "byteLength": floats.len() * 4}));
        bin.extend(floats.iter().flat_map(|value| value.to_le_bytes()));
    };
    view(&[-1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0, -1.0, 0.0, -1.0, -1.0, 0.0]);
    view([[0.0, 0.0, 1.0]; 4].as_flattened());
    view(UV.as_flattened());
    view(uv1.as_flattened());
    let indices = [0_u16, 3, 2, 0, 2, 1];
    views.push(json!({"buffer": 0, "byteOffset": bin.len(), "byteLength": 12}));
    bin.extend(indices.iter().flat_map(|index| index.to_le_bytes()));

    let floats = |view: u32, kind: &str| json!({"bufferView": view, "componentType": 5126, "count": 4, "type": kind});
    let mut positions = floats(0, "VEC3");
    positions["min"] = json!([-1, -1, 0]);
    positions["max"] = json!([1, 1, 0]);
    let indices = json!({"bufferView": 4, "componentType": 5123, "count": 6, "type": "SCALAR"});
    let attributes = json!({"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 3});
    let mut nodes: Vec<_> = places
        .iter()
        .map(|at| json!({"mesh": 0, "translation": at.to_array()}))
        .chain(
            (0..lights.len())
                .map(|index| json!({"extensions": {"KHR_lights_punctual": {"light": index}}})),
        )
        .collect();
    for (index, node) in nodes.iter_mut().enumerate() {
        node["extras"] = json!({"farlight_node": index});
    }
    let mut gltf = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 4, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.5, 0.5, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0
        }}],
        "accessors": [
            positions, floats(1, "VEC3"), floats(2, "VEC2"), floats(3, "VEC2"), indices
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": bin.len()}],
    });
    if !lights.is_empty() {
        gltf["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        gltf["extensions"] = json!({"KHR_lights_punctual": {"lights": lights}});
    }
    let mut text = gltf.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let length = 12 + 8 + text.len() + 8 + bin.len();
    let mut file = Vec::with_capacity(length);
    let word = |file: &mut Vec<u8>, value: usize| file.extend((value as u32).to_le_bytes());
    file.extend(b"glTF");
    word(&mut file, 2);
    word(&mut file, length);
    word(&mut file, text.len());
    file.extend(b"JSON");
    file.extend(text);
    word(&mut file, bin.len());
    file.extend(b"BIN\0");
    file.extend(bin);
    file
}
