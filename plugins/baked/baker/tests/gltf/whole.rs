//! Round trips: what was in the file is in the lit scene.

use std::{collections::BTreeMap, path::Path};

use farlight_baked_format::Fingerprint;
use farlight_baker::{
    gltf::{GltfError, Source, write},
    uv::{NoCache, SecondSet, UvOptions, UvSet, apply, second_sets},
};
use farlight_gi_solver::{
    import::{ImportLimits, ImportOptions, ImportedScene, load_scene_from_slice},
    scene::{Mesh, MeshId},
    unwrap::check_uv1,
};
use glam::Vec3;
use serde_json::json;

use crate::{
    check::{list, valid},
    glb::{Glb, PNG, SQUARE, rich},
};

pub(crate) type Sets = BTreeMap<MeshId, SecondSet>;

pub(crate) fn open(glb: &Glb) -> Source {
    Source::from_slice(&glb.bytes(), &ImportLimits::default()).unwrap()
}

pub(crate) fn sets_of(source: &Source, options: &UvOptions, scale: f32) -> (ImportedScene, Sets) {
    let import = ImportOptions { scale, ..Default::default() };
    let mut imported = source.scene(&import).unwrap();
    let sets = second_sets(&imported, source, options, &NoCache, &|_, _| true).unwrap();
    apply(&mut imported, &sets);
    (imported, sets)
}

/// Corners of all triangles, as the world sees them.
fn corners(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize])).collect()
}

/// Checks that what is written is what was solved, and reads it.
pub(crate) fn same(written: &[u8], imported: &ImportedScene, sets: &Sets) -> ImportedScene {
    let read = load_scene_from_slice(written, &ImportOptions::default()).unwrap();
    assert_eq!(read.scene.materials, imported.scene.materials);
    assert_eq!(read.light_ids, imported.light_ids);
    let ids = |i: &ImportedScene| i.scene.instances.keys().copied().collect::<Vec<_>>();
    assert_eq!(ids(&read), ids(imported));
    for (id, instance) in &imported.scene.instances {
        let (solved, lit) =
            (&imported.scene.meshes[&instance.mesh], &read.scene.meshes[&instance.mesh]);
        let other = &read.scene.instances[id];
        assert_eq!(other.material, instance.material);
        let mirrored = |t: &glam::Affine3A| t.matrix3.determinant() < 0.0;
        assert_eq!(mirrored(&other.transform), mirrored(&instance.transform));
        assert_eq!(solved.triangles.len(), lit.triangles.len());
        let far = solved.positions.iter().fold(1e-3, |far: f32, p| far.max(p.abs().max_element()));
        for (a, b) in corners(solved).into_iter().zip(corners(lit)) {
            for (a, b) in a.into_iter().zip(b) {
                let [a, b] =
                    [instance.transform.transform_point3(a), other.transform.transform_point3(b)];
                assert!(a.distance(b) <= far * 1e-5, "{a} {b}");
            }
        }
        let second = &sets[&instance.mesh];
        if matches!(second.set, UvSet::None { .. }) {
            continue;
        }
        assert_eq!(lit.uv1, solved.uv1);
        assert_eq!(lit.normals.len(), solved.normals.len());
        for (a, b) in solved.normals.iter().zip(&lit.normals) {
            assert!(a.distance(*b) < 1e-5);
        }
        assert_eq!(
            Fingerprint::of_uv(lit.uv1.iter().copied()),
            Fingerprint::of_uv(solved.uv1.clone())
        );
        // The engine makes flat normals by giving each corner a vertex.
        let split = lit.triangles.as_flattened().iter().enumerate().all(|(i, &v)| i as u32 == v);
        assert!(split || !lit.normals.is_empty());
    }
    read
}

#[test]
fn everything_comes_through() {
    let glb = rich();
    let source = open(&glb);
    let (imported, sets) = sets_of(&source, &UvOptions::default(), 1.0);
    let bytes = write(&source, &sets, 1.0).unwrap();
    assert_eq!(bytes, write(&source, &sets, 1.0).unwrap());
    let out = valid(&bytes);
    assert_eq!(out.left_over(), (0, 0));
    same(&bytes, &imported, &sets);

    let (old, new) = (&glb.json, &out.json);
    for key in [
        "asset",
        "scene",
        "scenes",
        "samplers",
        "textures",
        "materials",
        "cameras",
        "extensions",
        "extensionsUsed",
    ] {
        assert_eq!(old[key], new[key], "{key}");
    }
    assert_eq!(new["images"][0]["name"], "picture");
    assert_eq!(out.view(new["images"][0]["bufferView"].as_u64().unwrap() as usize), PNG);
    let animation = &new["animations"][0]["samplers"][0];
    assert_eq!(out.floats(animation["output"].as_u64().unwrap() as usize)[1], [1.0, 0.0, 0.0]);
    assert_eq!(new["animations"][0]["channels"], old["animations"][0]["channels"]);

    let mesh = &new["meshes"][0];
    assert_eq!(
        (&mesh["weights"], &mesh["extras"]),
        (&json!([0.5]), &json!({"targetNames": ["up"]}))
    );
    let first = &mesh["primitives"][0];
    assert_eq!(first["extras"], json!({"kept": true}));
    let at = |value: &serde_json::Value| value.as_u64().unwrap() as usize;
    let attributes = &first["attributes"];
    let places = out.floats(at(&attributes["POSITION"]));
    assert_eq!(out.json["accessors"][at(&attributes["POSITION"])]["name"], "places");
    assert!(places.iter().all(|p| p.len() == 3));
    let colors = out.elements(at(&attributes["COLOR_0"]));
    let custom = out.elements(at(&attributes["_CUSTOM"]));
    let target = out.floats(at(&first["targets"][0]["POSITION"]));
    let uv = out.floats(at(&attributes["TEXCOORD_0"]));
    for (i, place) in places.iter().enumerate() {
        let old = SQUARE.iter().position(|p| p == place.as_slice()).unwrap();
        assert_eq!(colors[i], [old as u8, 10, 20]);
        assert_eq!(custom[i], [old as u8]);
        assert_eq!(target[i], [0.0, 0.0, if old == 2 { 2.0 } else { 0.0 }]);
        assert_eq!(uv[i], [3.0 * place[0], 3.0 * place[1]]);
    }
    assert_eq!(
        out.json["accessors"][at(&first["targets"][0]["POSITION"])]["max"],
        json!([0.0, 0.0, 2.0])
    );

    // The strip became triangles; the lines stayed.
    assert_eq!(mesh["primitives"][1].get("mode"), None);
    assert_eq!(mesh["primitives"][2]["mode"], 1);
    let lines = out.elements(at(&mesh["primitives"][2]["indices"]));
    assert_eq!(lines, [[0], [1], [1], [2]]);
    assert_eq!(mesh["primitives"][2]["attributes"].as_object().unwrap().len(), 1);
    // The strip had no textures: its first set is there because sets are counted from 0.
    assert!(mesh["primitives"][1]["attributes"].get("TEXCOORD_0").is_some());
}

#[test]
fn nodes_are_marked_and_their_extras_stay() {
    let source = open(&rich());
    let bytes = write(&source, &Sets::new(), 1.0).unwrap();
    let nodes = valid(&bytes).json["nodes"].clone();
    assert_eq!(nodes[0]["extras"], json!({"farlight_node": 0}));
    assert_eq!(nodes[1].get("extras"), None);
    assert_eq!(nodes[2]["extras"], json!({"mine": 1, "farlight_node": 2}));
    assert_eq!(nodes[3]["extras"], "a word");
    assert_eq!(nodes[4]["extras"], json!({"value": "a word", "farlight_node": 4}));
    // Again: the same.
    let again = Source::from_slice(&bytes, &ImportLimits::default()).unwrap();
    assert_eq!(write(&again, &Sets::new(), 1.0).unwrap(), bytes);
}

#[test]
fn a_scene_in_millimetres_becomes_metres() {
    let mut glb = rich();
    // A second scene that shares a root with the first.
    glb.json["scenes"].as_array_mut().unwrap().push(json!({"nodes": [2]}));
    let source = open(&glb);
    let scale = 0.001;
    let options = UvOptions { texels_per_metre: 16000.0, ..Default::default() };
    let (imported, sets) = sets_of(&source, &options, scale);
    let bytes = write(&source, &sets, scale).unwrap();
    let out = valid(&bytes);
    let read = same(&bytes, &imported, &sets);
    for (id, light) in &imported.scene.lights {
        let other = &read.scene.lights[id];
        assert!(light.position.distance(other.position) < 1e-6);
    }
    // Ranges are those that the importer takes.
    let options = ImportOptions { range_window: true, ..Default::default() };
    let windowed = load_scene_from_slice(&bytes, &options).unwrap();
    let original = source.scene(&ImportOptions { scale, ..options }).unwrap();
    let range = |i: &ImportedScene| i.scene.lights.values().next().unwrap().range;
    assert_eq!(range(&windowed), range(&original));
    assert!((range(&windowed) - 0.007).abs() < 1e-8);

    let nodes = list(&out.json, "nodes");
    assert_eq!(nodes.len(), 7, "one for the shared root, one for the others");
    assert_eq!(nodes[2]["name"], "plain");
    let mut parents = vec![0; nodes.len()];
    for child in nodes.iter().flat_map(|n| list(n, "children")) {
        parents[child.as_u64().unwrap() as usize] += 1;
    }
    assert!(parents.iter().all(|&n| n <= 1), "{parents:?}");
    assert_eq!(list(&out.json["scenes"][1], "nodes").len(), 1);
    assert_eq!(out.json["scenes"][0]["name"], "all");

    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(write(&source, &sets, bad), Err(GltfError::Scale(_))), "{bad}");
    }
}

#[test]
fn a_file_without_scenes_gets_one() {
    let mut glb = rich();
    glb.json.as_object_mut().unwrap().remove("scenes");
    glb.json.as_object_mut().unwrap().remove("scene");
    let source = open(&glb);
    let (imported, sets) = sets_of(&source, &UvOptions::default(), 1.0);
    let bytes = write(&source, &sets, 1.0).unwrap();
    assert_eq!(valid(&bytes).json["scenes"], json!([{"nodes": [1, 2, 3, 4]}]));
    same(&bytes, &imported, &sets);
}

#[test]
fn buffers_and_images_beside_the_file_move_in() {
    let folder = tempfile::tempdir().unwrap();
    let mut glb = rich();
    glb.json["buffers"][0]["uri"] = "data%20of%20it.bin".into();
    // Twice the same picture, one that is missing, one inside of the text.
    glb.json["images"] = json!([{"uri": "a.png"}, {"uri": "b.jpg"}, {"uri": "gone.png"},
        {"uri": "data:image/webp;base64,Zm9vYg=="}]);
    for (name, data) in [("data of it.bin", glb.bin.as_slice()), ("a.png", PNG), ("b.jpg", PNG)] {
        std::fs::write(folder.path().join(name), data).unwrap();
    }
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, glb.json.to_string()).unwrap();
    let source = Source::open(&path, &ImportLimits::default()).unwrap();
    let names: Vec<_> = source.files().iter().map(|f| f.file_name().unwrap().to_owned()).collect();
    assert_eq!(names, ["scene.gltf", "data of it.bin", "a.png", "b.jpg"]);
    assert_eq!(source.warnings().len(), 1, "{:?}", source.warnings());
    assert!(source.warnings()[0].contains("gone.png"), "{:?}", source.warnings());

    let (imported, sets) = sets_of(&source, &UvOptions::default(), 1.0);
    // What was read is read: the folder may go.
    drop(folder);
    let bytes = write(&source, &sets, 1.0).unwrap();
    let out = valid(&bytes);
    let images = &out.json["images"];
    assert_eq!(images[0], images[1]);
    assert_eq!(images[0]["mimeType"], "image/png");
    assert_eq!(out.view(images[0]["bufferView"].as_u64().unwrap() as usize), PNG);
    assert_eq!(images[2], json!({"uri": "gone.png"}));
    assert_eq!(images[3]["mimeType"], "image/webp");
    assert_eq!(out.view(images[3]["bufferView"].as_u64().unwrap() as usize), b"foob");
    same(&bytes, &imported, &sets);

    let inside = open(&rich());
    assert_ne!(inside.fingerprint(), source.fingerprint());
    assert!(inside.files().is_empty());
}

#[test]
fn what_unknown_extensions_may_mean_stays() {
    let mut glb = rich();
    glb.json["nodes"][3]["extensions"] = json!({"ACME_secret": {"where": 3}});
    glb.json["extensionsUsed"].as_array_mut().unwrap().push("ACME_secret".into());
    let source = open(&glb);
    let (imported, sets) = sets_of(&source, &UvOptions::default(), 1.0);
    let bytes = write(&source, &sets, 1.0).unwrap();
    let out = valid(&bytes);
    let (old, new) = (list(&glb.json, "accessors"), list(&out.json, "accessors"));
    assert_eq!(new[..old.len()], *old);
    same(&bytes, &imported, &sets);
}

#[test]
fn overlapping_views_are_copied_once() {
    let mut glb = rich();
    let size = glb.bin.len();
    for i in 0..200 {
        // Nobody knows what this is for, so it stays.
        let view = json!({"buffer": 0, "byteOffset": i, "byteLength": size - i});
        let view = glb.push("bufferViews", view);
        glb.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    }
    let bytes = write(&open(&glb), &Sets::new(), 1.0).unwrap();
    assert!(bytes.len() < glb.bytes().len() + 40_000, "{} {}", bytes.len(), glb.bytes().len());
}

#[test]
fn damage_is_named() {
    let glb = rich();
    let (_, sets) = sets_of(&open(&glb), &UvOptions::default(), 1.0);
    let mut bad = glb.clone();
    bad.json["accessors"][2]["count"] = 5.into();
    let error = write(&open(&bad), &sets, 1.0).unwrap_err().to_string();
    assert!(error.contains("meshes[0].primitives[0].attributes.COLOR_0: 5 values"), "{error}");
    let mut bad = glb.clone();
    bad.json["animations"][0]["samplers"][0]["input"] = 900.into();
    // Somebody else's mistake, which stays as it is.
    write(&open(&bad), &sets, 1.0).unwrap();
    let mut bad = glb;
    bad.json["bufferViews"][0]["byteLength"] = (1_u64 << 40).into();
    // Nobody needs it.
    write(&open(&bad), &sets, 1.0).unwrap();
    bad.json["images"][0]["bufferView"] = 0.into();
    let error = write(&open(&bad), &sets, 1.0).unwrap_err().to_string();
    assert!(error.contains("bufferViews[0]"), "{error}");
}

#[test]
fn the_demo_scene_comes_through() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/scenes/doorway.glb");
    let source = Source::open(&path, &ImportLimits::default()).unwrap();
    let (imported, sets) = sets_of(&source, &UvOptions::default(), 1.0);
    let bytes = write(&source, &sets, 1.0).unwrap();
    assert_eq!(valid(&bytes).left_over(), (0, 0));
    same(&bytes, &imported, &sets);
    for set in sets.values() {
        assert!(!matches!(set.set, UvSet::Made { .. } | UvSet::None { .. }), "{:?}", set.set);
    }
}

/// Needs `FARLIGHT_TEST_DATA`.
#[test]
fn a_real_interior_comes_through() {
    let Some(folder) = std::env::var_os("FARLIGHT_TEST_DATA") else {
        println!("skipped: FARLIGHT_TEST_DATA does not name the folder with the test data");
        return;
    };
    let path = Path::new(&folder).join("scenes/hotel-room.glb");
    let source = Source::open(&path, &ImportLimits::default()).unwrap();
    // At this density the unwrapping takes seconds.
    let options = UvOptions { texels_per_metre: 8.0, ..Default::default() };
    let (imported, sets) = sets_of(&source, &options, 0.001);
    let bytes = write(&source, &sets, 0.001).unwrap();
    assert_eq!(valid(&bytes).left_over(), (0, 0));
    same(&bytes, &imported, &sets);
    for (id, set) in &sets {
        let mesh = &imported.scene.meshes[id];
        assert!(matches!(set.set, UvSet::Made { .. }), "{id:?}");
        assert_eq!(check_uv1(mesh, 1024), Ok(()), "{id:?}");
    }
}
