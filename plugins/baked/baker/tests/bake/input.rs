//! What counts as a change.

use std::fs;

use farlight_baker::{BakeError, Emission, Outcome, Probes, Texels};
use serde_json::json;

use crate::{Ear, contents, quick, run};

/// A floor under a lamp, with its positions in another file.
fn write(folder: &std::path::Path, height: f32) -> std::path::PathBuf {
    let corners = [[0.0, height, 0.0], [0.0, height, 2.0], [2.0, height, 2.0], [2.0, height, 0.0]];
    let mut bytes: Vec<u8> =
        corners.as_flattened().iter().flat_map(|v: &f32| v.to_le_bytes()).collect();
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    fs::write(folder.join("floor.bin"), &bytes).unwrap();
    let scene = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 10.0 }] } },
        "buffers": [{ "uri": "floor.bin", "byteLength": bytes.len() }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 12 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
              "min": [0.0, height, 0.0], "max": [2.0, height, 2.0] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "materials": [{ "name": "glow", "emissiveFactor": [0.0, 0.0, 1.0] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "nodes": [
            { "name": "floor", "mesh": 0 },
            { "name": "lamp", "translation": [1.0, 1.0, 1.0],
              "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        ],
        "scenes": [{ "nodes": [0, 1] }],
        "scene": 0,
    });
    let path = folder.join("floor.gltf");
    fs::write(&path, scene.to_string()).unwrap();
    path
}

#[test]
fn a_file_beside_the_scene_counts() {
    let folder = tempfile::tempdir().unwrap();
    let scene = write(folder.path(), 0.0);
    let out = folder.path().join("out");
    let bake = |scene: &std::path::Path| {
        let report = run(quick(scene, &out), &mut Ear::default()).unwrap();
        (report.outcome, contents(&out))
    };
    let (outcome, first) = bake(&scene);
    assert_eq!(outcome, Outcome::Complete);
    assert_eq!(bake(&scene).0, Outcome::Unchanged);
    // The lamp is nearer: only the other file says so. (Bounds in the JSON are the same.)
    let json = fs::read(&scene).unwrap();
    write(folder.path(), 0.5);
    fs::write(&scene, json).unwrap();
    let (outcome, second) = bake(&scene);
    assert_eq!(outcome, Outcome::Complete);
    assert!(first != second);
    fs::remove_file(folder.path().join("floor.bin")).unwrap();
    let error = run(quick(&scene, &out), &mut Ear::default()).unwrap_err();
    assert!(matches!(error, BakeError::Import(_)) && error.to_string().contains("floor.bin"));
    assert!(contents(&out) == second, "after an error all is as it was");
}

#[test]
fn light_is_that_of_the_lamp_in_its_unit() {
    let folder = tempfile::tempdir().unwrap();
    let scene = write(folder.path(), 0.0);
    let out = folder.path().join("out");
    let mut options = quick(&scene, &out);
    options.denoise = false;
    options.probes = Probes::None;
    options.emission = Emission::Nits;
    let report = run(options.clone(), &mut Ear::default()).unwrap();
    let manifest = &report.manifest;
    let picture = fs::read(out.join(&manifest.scenarios[0].pages[0].exr)).unwrap();
    let picture = farlight_baked_format::exr::Picture::read(&picture).unwrap();
    // Below the lamp, at 1 m: E / pi = 10 cd / pi, times the window of a range of 20 m.
    let [x, y, w, h] = manifest.receivers[0].rect;
    let middle = picture.texels[((y + h / 2) * manifest.page_size + x + w / 2) as usize];
    let expected = 10.0 / std::f32::consts::PI * (1.0 - (1.0_f32 / 20.0).powi(4)).powi(2);
    assert!((middle.x / expected - 1.0).abs() < 0.01, "{middle} {expected}");

    // The scale is in the lit scene and in the light: at 10 m there is a hundredth.
    options.scale = 10.0;
    options.texels = Texels::Page(64);
    let report = run(options, &mut Ear::default()).unwrap();
    let manifest = &report.manifest;
    let picture = fs::read(out.join(&manifest.scenarios[0].pages[0].exr)).unwrap();
    let picture = farlight_baked_format::exr::Picture::read(&picture).unwrap();
    let [x, y, w, h] = manifest.receivers[0].rect;
    let middle = picture.texels[((y + h / 2) * manifest.page_size + x + w / 2) as usize];
    let expected = 0.1 / std::f32::consts::PI * (1.0 - (10.0_f32 / 20.0).powi(4)).powi(2);
    assert!((middle.x / expected - 1.0).abs() < 0.01, "{middle} {expected}");
    assert_eq!(manifest.scenarios[0].lights[0].position, [10.0, 10.0, 10.0]);
}

/// The floor glows, and its light is seen by probes above it.
#[test]
fn emission_follows_the_exposure() {
    let folder = tempfile::tempdir().unwrap();
    let scene = write(folder.path(), 0.0);
    let up = |emission: Emission| {
        let out = folder.path().join(format!("{emission:?}"));
        let mut options = quick(&scene, &out);
        options.emission = emission;
        let report = run(options, &mut Ear::default()).unwrap();
        let volume = fs::read(out.join(&report.manifest.scenarios[0].volumes[0])).unwrap();
        let texture = farlight_baked_format::ktx2::Texture::read(&volume).unwrap();
        texture.texels.iter().map(|texel| texel.z).fold(0.0, f32::max)
    };
    let (nits, exposed) = (up(Emission::Nits), up(Emission::Exposure(9.7)));
    let factor = 1.2 * 9.7_f32.exp2();
    // The lamp's light is part of both.
    assert!(exposed > 0.3 * factor && exposed < 1.1 * factor, "{exposed}");
    assert!(nits < 10.0, "{nits}");
}
