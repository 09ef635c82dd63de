//! Parts, materials and images as binary glTF.

use std::fmt::Write;

use super::{part::Part, png::Indexed};

/// A dielectric material.
pub(super) struct Material {
    pub(super) name: &'static str,
    /// Linear base colour.
    pub(super) color: [f32; 3],
    /// Index of an image.
    pub(super) image: Option<usize>,
    pub(super) roughness: f32,
    /// Whether backs are drawn too. Bevy's shadow maps leave out backs that are not: a lamp outside
    /// would shine through a wall that faces the inside.
    pub(super) double_sided: bool,
}

/// The file of a scene: one node, mesh and primitive a part.
pub(super) fn write(
    scene: &str,
    parts: &[Part],
    materials: &[Material],
    images: &[(&str, Indexed)],
) -> Vec<u8> {
    let mut file = Writer::default();
    let (mut nodes, mut meshes) = (Vec::new(), Vec::new());
    for (i, part) in parts.iter().enumerate() {
        let geometry = part.build();
        let bounds = bounds(&geometry.positions);
        let vertices = geometry.positions.len();
        assert!(vertices < 1 << 16, "indices have 16 bits");
        let position = file.accessor(
            floats(geometry.positions.as_flattened()),
            F32,
            vertices,
            "VEC3",
            &bounds,
        );
        let normal =
            file.accessor(floats(geometry.normals.as_flattened()), F32, vertices, "VEC3", "");
        let uv0 = file.accessor(floats(geometry.uv0.as_flattened()), F32, vertices, "VEC2", "");
        let uv1 = file.accessor(floats(geometry.uv1.as_flattened()), F32, vertices, "VEC2", "");
        let indices = geometry.triangles.as_flattened();
        let bytes = indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect();
        let index = file.accessor(bytes, U16, indices.len(), "SCALAR", "");
        nodes.push(format!(r#"{{"name":"{}","mesh":{i}}}"#, part.name));
        meshes.push(format!(
            r#"{{"name":"{}","primitives":[{{"attributes":{{"POSITION":{position},"NORMAL":{normal},"TEXCOORD_0":{uv0},"TEXCOORD_1":{uv1}}},"indices":{index},"material":{}}}]}}"#,
            part.name, part.material
        ));
    }
    let (mut json_images, mut textures) = (Vec::new(), Vec::new());
    for (i, (name, image)) in images.iter().enumerate() {
        let view = file.view(image.to_png(), "");
        json_images
            .push(format!(r#"{{"name":"{name}","bufferView":{view},"mimeType":"image/png"}}"#));
        textures.push(format!(r#"{{"source":{i},"sampler":0}}"#));
    }
    let materials: Vec<_> = materials.iter().map(material).collect();
    let roots: Vec<_> = (0..nodes.len()).map(|i| i.to_string()).collect();
    let mut json =
        String::from(r#"{"asset":{"version":"2.0","generator":"cargo xtask assets"},"scene":0"#);
    let mut list = |name: &str, values: &[String]| {
        write!(json, ",\"{name}\":[{}]", values.join(",")).expect("a string takes all");
    };
    list("scenes", &[format!(r#"{{"name":"{scene}","nodes":[{}]}}"#, roots.join(","))]);
    list("nodes", &nodes);
    list("meshes", &meshes);
    list("materials", &materials);
    list("textures", &textures);
    list("images", &json_images);
    // Linear, trilinear, repeat.
    list(
        "samplers",
        &[r#"{"magFilter":9729,"minFilter":9987,"wrapS":10497,"wrapT":10497}"#.into()],
    );
    list("accessors", &file.accessors);
    list("bufferViews", &file.views);
    list("buffers", &[format!(r#"{{"byteLength":{}}}"#, file.bytes.len())]);
    json.push('}');
    pack(json.into_bytes(), file.bytes)
}

const U16: u32 = 5123;
const F32: u32 = 5126;

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Writer {
    fn view(&mut self, bytes: Vec<u8>, target: &str) -> usize {
        self.views.push(format!(
            r#"{{"buffer":0,"byteOffset":{},"byteLength":{}{target}}}"#,
            self.bytes.len(),
            bytes.len()
        ));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(
        &mut self,
        bytes: Vec<u8>,
        kind: u32,
        count: usize,
        shape: &str,
        more: &str,
    ) -> usize {
        let target = if kind == U16 { r#","target":34963"# } else { r#","target":34962"# };
        let view = self.view(bytes, target);
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{kind},"count":{count},"type":"{shape}"{more}}}"#
        ));
        self.accessors.len() - 1
    }
}

fn material(material: &Material) -> String {
    let [r, g, b] = material.color;
    let image =
        material.image.map_or(String::new(), |i| format!(r#","baseColorTexture":{{"index":{i}}}"#));
    let sides = if material.double_sided { r#","doubleSided":true"# } else { "" };
    format!(
        r#"{{"name":"{}","pbrMetallicRoughness":{{"baseColorFactor":[{r},{g},{b},1],"metallicFactor":0,"roughnessFactor":{}{image}}}{sides}}}"#,
        material.name, material.roughness
    )
}

fn bounds(positions: &[[f32; 3]]) -> String {
    let fold = |start: f32, f: fn(f32, f32) -> f32| {
        [0, 1, 2].map(|k| positions.iter().map(|p| p[k]).fold(start, f))
    };
    let (low, high) = (fold(f32::MAX, f32::min), fold(f32::MIN, f32::max));
    format!(r#","min":{low:?},"max":{high:?}"#).replace(' ', "")
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// What a surface of a model is made of.
#[derive(Clone, Copy)]
pub(super) enum Look {
    /// The measured material goes here; without one it is plain cloth. Named `btf`.
    Btf,
    /// Black glass. Named `bead`.
    Bead,
    /// Dark wood. Named `form`.
    Form,
}

/// A primitive of a model, as the file holds it.
pub(super) struct Surface {
    pub(super) look: Look,
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) tangents: Vec<[f32; 4]>,
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A model: one node and mesh with a primitive a surface, tangents and one UV set.
pub(super) fn write_surfaces(name: &str, surfaces: &[Surface]) -> Vec<u8> {
    let mut file = Writer::default();
    let mut primitives = Vec::new();
    for surface in surfaces {
        let vertices = surface.positions.len();
        assert!(vertices < 1 << 16, "indices have 16 bits");
        let bounds = bounds(&surface.positions);
        let position =
            file.accessor(floats(surface.positions.as_flattened()), F32, vertices, "VEC3", &bounds);
        let normal =
            file.accessor(floats(surface.normals.as_flattened()), F32, vertices, "VEC3", "");
        let tangent =
            file.accessor(floats(surface.tangents.as_flattened()), F32, vertices, "VEC4", "");
        let uv = file.accessor(floats(surface.uvs.as_flattened()), F32, vertices, "VEC2", "");
        let indices = surface.triangles.as_flattened();
        let bytes = indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect();
        let index = file.accessor(bytes, U16, indices.len(), "SCALAR", "");
        primitives.push(format!(
            r#"{{"attributes":{{"POSITION":{position},"NORMAL":{normal},"TANGENT":{tangent},"TEXCOORD_0":{uv}}},"indices":{index},"material":{}}}"#,
            surface.look as usize
        ));
    }
    let materials = [
        material(&Material {
            name: "btf",
            color: [0.6, 0.55, 0.48],
            image: None,
            roughness: 0.8,
            double_sided: false,
        }),
        material(&Material {
            name: "bead",
            color: [0.01; 3],
            image: None,
            roughness: 0.18,
            double_sided: false,
        }),
        material(&Material {
            name: "form",
            color: [0.05, 0.04, 0.035],
            image: None,
            roughness: 0.9,
            double_sided: false,
        }),
    ];
    let json = format!(
        r#"{{"asset":{{"version":"2.0","generator":"cargo xtask assets"}},"scene":0,"scenes":[{{"name":"{name}","nodes":[0]}}],"nodes":[{{"name":"{name}","mesh":0}}],"meshes":[{{"name":"{name}","primitives":[{}]}}],"materials":[{}],"accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}}"#,
        primitives.join(","),
        materials.join(","),
        file.accessors.join(","),
        file.views.join(","),
        file.bytes.len()
    );
    pack(json.into_bytes(), file.bytes)
}

/// Header, JSON chunk, binary chunk.
fn pack(mut json: Vec<u8>, mut bytes: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let mut glb = b"glTF".to_vec();
    let word = |glb: &mut Vec<u8>, v: usize| glb.extend((v as u32).to_le_bytes());
    word(&mut glb, 2);
    word(&mut glb, 12 + 8 + json.len() + 8 + bytes.len());
    word(&mut glb, json.len());
    glb.extend(b"JSON");
    glb.extend(&json);
    word(&mut glb, bytes.len());
    glb.extend(b"BIN\0");
    glb.extend(&bytes);
    glb
}
