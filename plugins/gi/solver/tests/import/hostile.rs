//! Files that are broken or that lie: clear errors, no panic, bounded memory.

use farlight_gi_solver::{
    World,
    import::{ImportLimits, ImportOptions, ImportProblem, ImportedScene, load_scene_from_slice},
    scene::Mesh,
};
use glam::Vec3;
use serde_json::{Value, json};

use crate::{
    glb::{Glb, SQUARE, SQUARE_INDICES, png, rich, square, write},
    memory,
};

const NAN: f32 = f32::NAN;

fn import(glb: &Glb) -> ImportedScene {
    load_scene_from_slice(&glb.bytes(), &ImportOptions::default()).unwrap()
}

/// The error's text; it must come before much memory is taken.
fn refused(bytes: &[u8], options: &ImportOptions) -> String {
    let (result, peak) = memory::peak(|| load_scene_from_slice(bytes, options));
    assert!(peak < 32 << 20, "{peak} bytes for a file of {}", bytes.len());
    match result {
        Ok(imported) => panic!("was read, with {:?}", imported.warnings),
        Err(error) => error.to_string(),
    }
}

fn only_mesh(imported: &ImportedScene) -> &Mesh {
    assert_eq!(imported.scene.meshes.len(), 1);
    let mesh = imported.scene.meshes.values().next().unwrap();
    mesh.validate().unwrap();
    mesh
}

/// The square with other positions.
fn positions(values: &[[f32; 3]], indices: &[u32]) -> Glb {
    let mut glb = Glb::new();
    let position = glb.floats(values);
    let indices = glb.indices(indices);
    glb.mesh(json!({"attributes": {"POSITION": position}, "indices": indices}));
    glb
}

#[test]
fn triangles_with_nan_positions_are_left_out() {
    for bad in [NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
        let mut corners = SQUARE;
        corners[3][1] = bad;
        let imported = import(&positions(&corners, &SQUARE_INDICES));
        assert_eq!(only_mesh(&imported).triangles, [[0, 1, 2]]);
        assert!(imported.warnings[0].contains("1 of 2 triangles have a corner"));
        assert_eq!(World::new(&imported.scene).triangle_count(), 1);
    }
    let imported = import(&positions(&[[NAN; 3]; 4], &SQUARE_INDICES));
    assert!(imported.scene.instances.is_empty());
    assert!(imported.warnings.iter().any(|w| w.contains("has no triangles")));
}

#[test]
fn triangles_without_an_area_are_left_out() {
    let mut indices = SQUARE_INDICES.to_vec();
    // Two corners the same; three in a line; all in one point.
    indices.extend([1, 1, 2, 0, 1, 4, 5, 5, 5]);
    let corners = [SQUARE.as_slice(), &[[0.5, 0.0, 0.0], [7.0, 7.0, 7.0]]].concat();
    let imported = import(&positions(&corners, &indices));
    assert_eq!(only_mesh(&imported).triangles.len(), 2);
    assert_eq!(imported.warnings.len(), 1);
    assert!(imported.warnings[0].contains("3 of 5 triangles have no area"));
}

#[test]
fn normals_that_are_no_directions_are_made_from_faces() {
    let mut glb = square();
    let normals = [[NAN, 0.0, 1.0], [0.0; 3], [0.0, f32::INFINITY, 0.0], [0.0, 3.0, 4.0]];
    let normal = glb.floats(&normals);
    glb.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normal.into();
    let imported = import(&glb);
    let expected = [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::new(0.0, 0.6, 0.8)];
    for (found, expected) in only_mesh(&imported).normals.iter().zip(expected) {
        assert!(found.distance(expected) < 1e-6, "{found} instead of {expected}");
    }
    assert!(imported.warnings[0].contains("3 normals"), "{:?}", imported.warnings);
}

#[test]
fn texture_coordinates_that_are_no_numbers_are_left_out() {
    let mut glb = square();
    let good = glb.floats(&[[0.5_f32; 2]; 4]);
    let bad = glb.floats(&[[0.5, NAN]; 4]);
    let attributes = &mut glb.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_0"] = good.into();
    attributes["TEXCOORD_1"] = bad.into();
    let imported = import(&glb);
    let mesh = only_mesh(&imported);
    assert_eq!((mesh.uv0.len(), mesh.uv1.len()), (4, 0));
    assert!(imported.warnings[0].contains("TEXCOORD_1"), "{:?}", imported.warnings);
}

#[test]
fn missing_normals_are_no_problem() {
    let imported = import(&square());
    assert!(only_mesh(&imported).normals.is_empty());
    assert_eq!(imported.warnings, Vec::<String>::new());
    assert_eq!(World::new(&imported.scene).triangle_count(), 2);
}

#[test]
fn every_truncation_is_refused() {
    let bytes = rich().bytes();
    let options = ImportOptions::default();
    for length in 0..bytes.len() {
        let error = refused(&bytes[..length], &options);
        assert!(error.starts_with("glTF data in memory"), "{error}");
    }
    // Also if the header is made to agree.
    for length in 12..bytes.len() {
        let mut bytes = bytes[..length].to_vec();
        bytes[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        // Cut padding is forgiven.
        _ = load_scene_from_slice(&bytes, &options);
    }
}

/// Sets the value at a JSON pointer and returns the error.
fn spoiled(base: &Glb, pointer: &str, value: impl Into<Value>) -> String {
    let mut glb = base.clone();
    *glb.json.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer}")) = value.into();
    refused(&glb.bytes(), &ImportOptions::default())
}

#[test]
fn lying_counts_and_offsets_are_refused_where_they_lie() {
    let base = rich();
    let primitive = "mesh 0 \"pair\", primitive";
    for (pointer, value, place) in [
        ("/accessors/0/count", u64::MAX, "vertices"),
        ("/accessors/0/count", 5, "POSITION"),
        ("/accessors/0/count", 1 << 40, "vertices"),
        ("/accessors/1/count", 3, "NORMAL"),
        ("/accessors/2/count", 1 << 62, "TEXCOORD_0"),
        ("/accessors/3/count", 1 << 33, "triangles"),
        ("/accessors/3/count", 9, "indices"),
        ("/accessors/0/bufferView", 999, "buffer view 999"),
        ("/bufferViews/0/byteLength", 1 << 50, primitive),
        ("/bufferViews/0/byteOffset", u64::MAX, primitive),
        ("/bufferViews/0/buffer", 7, "buffer 7"),
        ("/bufferViews/4/byteStride", 252, primitive),
        ("/bufferViews/4/byteStride", 5, "stride"),
        ("/accessors/4/sparse/count", 99, primitive),
        ("/accessors/4/sparse/count", u64::MAX, primitive),
        ("/accessors/4/sparse/indices/bufferView", 99, "buffer view 99"),
        ("/accessors/0/componentType", 5125, "POSITION"),
        ("/accessors/0/componentType", 1, "component type"),
        ("/accessors/3/componentType", 5126, "indices"),
        ("/meshes/0/primitives/0/attributes/POSITION", 99, "accessor 99"),
        ("/meshes/0/primitives/0/indices", 99, "accessor 99"),
        ("/meshes/0/primitives/0/indices", 0, "indices"),
        ("/meshes/0/primitives/0/attributes/POSITION", 2, "POSITION"),
        ("/meshes/0/primitives/0/mode", 7, "mode"),
        ("/meshes/0/primitives/0/material", 9, "material 9"),
        ("/materials/0/emissiveTexture/index", 9, "texture 9"),
        ("/nodes/0/mesh", 9, "mesh 9"),
        ("/nodes/1/children/0", 99, "node 99"),
        ("/nodes/2/extensions/KHR_lights_punctual/light", 9, "light 9"),
        ("/scene", 9, "scene 9"),
        ("/buffers/0/byteLength", 1 << 40, "buffer 0"),
    ] {
        let error = spoiled(&base, pointer, value);
        assert!(error.contains(place), "{pointer} = {value}: {error}");
    }
    for (pointer, value, place) in [
        ("/accessors/0/type", "VEC7", "accessor 0"),
        ("/accessors/0/type", "MAT4", "POSITION"),
        ("/asset/version", "1.0", "glTF 2.0"),
        ("/extensionsUsed", "x", "is not glTF"),
    ] {
        let error = spoiled(&base, pointer, value);
        assert!(error.contains(place), "{pointer} = {value}: {error}");
    }
    let error = spoiled(&base, "/accessors/0/count", -1);
    assert!(error.contains("is not glTF"), "{error}");
    // Indices that name vertices that are not there.
    let error = refused(&positions(&SQUARE, &[0, 1, 4]).bytes(), &ImportOptions::default());
    assert!(error.contains("triangle 0 names vertex 4, but there are 4"), "{error}");
}

#[test]
fn lying_chunks_are_refused() {
    let good = square().bytes();
    let json_length = u32::from_le_bytes(good[12..16].try_into().unwrap()) as usize;
    for (at, value) in [
        (4, 1_u32),
        (8, u32::MAX),
        (12, u32::MAX),
        (12, 0),
        (16, 0x1234),
        (20 + json_length, u32::MAX),
    ] {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        refused(&bytes, &ImportOptions::default());
    }
    for bytes in [&b""[..], b"glTF", b"PK\x03\x04", b"{", b"{}", b"[]", b"{\"asset\":{}}"] {
        refused(bytes, &ImportOptions::default());
    }
}

#[test]
fn required_extensions_that_change_shapes_are_refused() {
    for (extension, fix) in
        [("KHR_draco_mesh_compression", "without mesh compression"), ("X_other", "without it")]
    {
        let mut glb = square();
        glb.json["extensionsRequired"] = json!([extension]);
        let error = refused(&glb.bytes(), &ImportOptions::default());
        assert!(error.contains(extension) && error.contains(fix), "{error}");
    }
    let mut glb = square();
    glb.json["extensionsRequired"] = json!(["KHR_materials_sheen", "KHR_mesh_quantization"]);
    assert_eq!(import(&glb).scene.instances.len(), 1);
}

#[test]
fn hierarchies_may_be_cyclic_or_deep() {
    let mut glb = square();
    glb.json["nodes"][0]["children"] = json!([0]);
    let imported = import(&glb);
    assert_eq!(imported.scene.instances.len(), 1);
    assert!(imported.warnings[0].contains("its own ancestor"), "{:?}", imported.warnings);

    let mut glb = square();
    let nodes: Vec<_> = (1..100_000).map(|i| json!({"children": [i + 1]})).collect();
    let list = glb.json["nodes"].as_array_mut().unwrap();
    list.extend(nodes);
    list.push(json!({}));
    glb.json["scenes"][0]["nodes"] = json!([1]);
    let (result, peak) =
        memory::peak(|| load_scene_from_slice(&glb.bytes(), &ImportOptions::default()));
    let error = result.unwrap_err();
    assert!(matches!(error.problem, ImportProblem::Limit { field: "depth", .. }), "{error}");
    assert!(peak < 256 << 20, "{peak}");

    // JSON that is nested without end.
    let json = [&b"{\"asset\":{\"version\":\"2.0\"},\"extras\":"[..], &[b'['; 1 << 20]].concat();
    assert!(refused(&write(&json, &[]), &ImportOptions::default()).contains("is not glTF"));
}

#[test]
fn transforms_that_are_not_finite_or_flat_leave_the_instance_out() {
    for (key, value) in [
        ("scale", json!([0, 1, 1])),
        ("scale", json!([1e30, 1, 1])),
        ("translation", json!([1e38, 0, 0])),
        ("matrix", json!([1e30, 0, 0, 0, 0, 1e30, 0, 0, 0, 0, 1e30, 0, 0, 0, 0, 1])),
    ] {
        let mut glb = square();
        glb.json["nodes"][0][key] = value;
        let imported = import(&glb);
        assert!(imported.scene.instances.is_empty(), "{key}");
        assert!(imported.warnings[0].contains("node 0"), "{:?}", imported.warnings);
    }
}

#[test]
fn images_that_do_not_decode_leave_the_colour() {
    let mut glb = rich();
    let broken = png(64, 64, [1, 2, 3, 4]);
    let view = glb.view(&broken[..60]);
    glb.json["images"][0]["bufferView"] = view.into();
    let imported = import(&glb);
    assert!(imported.scene.textures.is_empty());
    assert!(imported.warnings.iter().all(|w| w.contains("colour factor is used alone")));

    // A picture of 60000 x 60000 pixels in a few bytes.
    let mut bomb = png(1, 1, [0; 4]);
    for at in [16, 20] {
        bomb[at..at + 4].copy_from_slice(&60_000_u32.to_be_bytes());
    }
    let crc = !bomb[12..29].iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    });
    bomb[29..33].copy_from_slice(&crc.to_be_bytes());
    let mut glb = rich();
    let view = glb.view(&bomb);
    glb.json["images"][0]["bufferView"] = view.into();
    let error = refused(&glb.bytes(), &ImportOptions::default());
    assert!(error.contains("3600000000 texels"), "{error}");
}

#[test]
fn limits_are_errors_that_name_themselves() {
    let bytes = rich().bytes();
    let all = ImportLimits::default();
    for (limits, field) in [
        (ImportLimits { file_bytes: 1000, ..all.clone() }, "file_bytes"),
        (ImportLimits { json_values: 20, ..all.clone() }, "json_values"),
        (ImportLimits { triangles: 3, ..all.clone() }, "triangles"),
        (ImportLimits { vertices: 7, ..all.clone() }, "vertices"),
        (ImportLimits { texture_texels: 14, ..all.clone() }, "texture_texels"),
        (ImportLimits { depth: 1, ..all.clone() }, "depth"),
    ] {
        let error = refused(&bytes, &ImportOptions { limits, ..Default::default() });
        assert!(error.contains(&format!("ImportLimits::{field}")), "{error}");
    }
    let exact = ImportLimits { triangles: 4, vertices: 8, texture_texels: 30, depth: 2, ..all };
    load_scene_from_slice(&bytes, &ImportOptions { limits: exact, ..Default::default() }).unwrap();
}

#[test]
fn few_bytes_cannot_become_many_triangles() {
    // One large mesh many times.
    let mut glb = square();
    for _ in 0..1000 {
        glb.node(json!({"mesh": 0}));
    }
    let limits = ImportLimits { triangles: 1000, ..Default::default() };
    let error = refused(&glb.bytes(), &ImportOptions { limits, ..Default::default() });
    assert!(error.contains("each counted once an instance"), "{error}");

    // Accessors without data are all zeros, as many as they like.
    let mut glb = Glb::new();
    let places = glb.view(&[0; 4]);
    let values = glb.view(&[0; 12]);
    let position = glb.push(
        "accessors",
        json!({"componentType": 5126, "count": 4_000_000_000_u64, "type": "VEC3", "sparse": {
            "count": 1, "indices": {"bufferView": places, "componentType": 5121},
            "values": {"bufferView": values}}}),
    );
    glb.mesh(json!({"attributes": {"POSITION": position}}));
    let error = refused(&glb.bytes(), &ImportOptions::default());
    assert!(error.contains("ImportLimits::vertices"), "{error}");
}

#[test]
fn warnings_do_not_pile_up() {
    let mut glb = square();
    for i in 0..1000 {
        glb.node(json!({"mesh": 0, "scale": [0, 0, 0], "name": "x".repeat(i)}));
    }
    let warnings = import(&glb).warnings;
    assert_eq!(warnings.len(), 101);
    assert_eq!(warnings[100], "and 900 more warnings");
    assert!(warnings.iter().all(|w| w.len() < 200));
}

/// Ten million triangles: refused under a smaller limit, read under the default one.
#[test]
fn ten_million_triangles_are_read_in_bounded_memory_or_refused() {
    const N: u32 = 2237; // 2 * N² is a little over ten million.
    let mut glb = Glb::new();
    let corners: Vec<[f32; 3]> =
        (0..=N).flat_map(|y| (0..=N).map(move |x| [x as f32, (x ^ y) as f32, y as f32])).collect();
    let position = glb.floats(&corners);
    drop(corners);
    let at = |x: u32, y: u32| y * (N + 1) + x;
    let indices: Vec<u32> = (0..N)
        .flat_map(|y| (0..N).map(move |x| (x, y)))
        .flat_map(|(x, y)| {
            [at(x, y), at(x, y + 1), at(x + 1, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)]
        })
        .collect();
    let triangles = indices.len() / 3;
    let indices = glb.indices(&indices);
    glb.mesh(json!({"attributes": {"POSITION": position}, "indices": indices}));
    let bytes = glb.bytes();
    drop(glb);

    let limits = ImportLimits { triangles: 5_000_000, ..Default::default() };
    let (result, peak) = memory::peak(|| {
        load_scene_from_slice(&bytes, &ImportOptions { limits, ..Default::default() })
    });
    let error = result.unwrap_err().to_string();
    assert!(
        error.contains("has 10008338 triangles in one primitive, the limit is 5000000"),
        "{error}"
    );
    // The positions were read before the indices were looked at.
    assert!(peak < 100 << 20, "{} MB to refuse it", peak >> 20);

    let start = std::time::Instant::now();
    let (imported, peak) =
        memory::peak(|| load_scene_from_slice(&bytes, &ImportOptions::default()).unwrap());
    println!("{triangles} triangles in {:?}, {} MB", start.elapsed(), peak >> 20);
    assert_eq!(only_mesh(&imported).triangles.len(), triangles);
    // What is kept takes 12 bytes a vertex and a triangle: 180 MB; at most once more beside it.
    assert!(peak < 360 << 20, "{} MB", peak >> 20);
}
