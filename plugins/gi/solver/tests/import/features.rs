//! What the importer makes of each glTF feature.

use std::f32::consts::FRAC_1_SQRT_2;

use crate::glb::{Glb, SQUARE, SQUARE_INDICES, rich, square};
use farlight_gi_solver::{
    import::{DEFAULT_MATERIAL, ImportOptions, ImportedScene, load_scene, load_scene_from_slice},
    scene::{AlphaMode, InstanceId, LightKind, MaterialId, Mesh},
};
use glam::{Vec2, Vec3, Vec4};
use serde_json::json;

fn import(glb: &Glb) -> ImportedScene {
    load_scene_from_slice(&glb.bytes(), &ImportOptions::default()).unwrap()
}

fn only_mesh(imported: &ImportedScene) -> &Mesh {
    assert_eq!(imported.scene.meshes.len(), 1);
    imported.scene.meshes.values().next().unwrap()
}

#[test]
fn a_rich_file_is_read_without_a_warning() {
    let imported = import(&rich());
    assert_eq!(imported.warnings, Vec::<String>::new());
    assert_eq!(imported.scene.meshes.len(), 2);
    assert_eq!(imported.instance_names[&InstanceId(0)], "node 0 \"child\", primitive 0");
}

#[test]
fn lights_keep_their_numbers_and_the_order_of_their_nodes() {
    let imported = import(&rich());
    let lights: Vec<_> = imported.light_ids.iter().map(|id| imported.scene.lights[id]).collect();
    let kinds: Vec<_> = lights.iter().map(|l| l.kind).collect();
    let spot = LightKind::Spot { inner_angle: 0.2, outer_angle: 0.4 };
    assert_eq!(kinds, [LightKind::Directional, LightKind::Point, spot]);
    assert_eq!(lights[0].intensity, Vec3::ONE);
    assert_eq!(lights[1].intensity, Vec3::new(4.0, 2.0, 1.0));
    assert_eq!(lights[2].position, Vec3::Y);
    // -z turned by -90 degrees about x points down.
    assert!(lights[0].direction.distance(Vec3::NEG_Y) < 1e-6, "{}", lights[0].direction);
    assert!(lights.iter().all(|l| l.range == f32::INFINITY));
}

#[test]
fn the_range_window_is_bevys() {
    let options = ImportOptions { range_window: true, scale: 0.5, ..Default::default() };
    let imported = load_scene_from_slice(&rich().bytes(), &options).unwrap();
    let range = |i: usize| imported.scene.lights[&imported.light_ids[i]].range;
    assert_eq!((range(1), range(2)), (3.5, 20.0));
}

#[test]
fn transforms_multiply_and_scale_reaches_positions_and_translations() {
    let options = ImportOptions { scale: 0.5, ..Default::default() };
    let imported = load_scene_from_slice(&rich().bytes(), &options).unwrap();
    let instance = &imported.scene.instances[&InstanceId(0)];
    let mesh = &imported.scene.meshes[&instance.mesh];
    // (1, 1, 0) is mirrored and stretched to (-2, 1, 0), turned by 90 degrees about y to (0, 1, 2),
    // moved to (1, 3, 5), halved.
    let corner = instance.transform.transform_point3(mesh.positions[2]);
    assert!(corner.distance(Vec3::new(0.5, 1.5, 2.5)) < 1e-6, "{corner}");
    assert!(instance.transform.matrix3.determinant() < 0.0);
}

#[test]
fn materials_are_taken_as_they_are() {
    let scene = import(&rich()).scene;
    let lamp = &scene.materials[&MaterialId(0)];
    assert_eq!(lamp.emissive, Vec3::new(8.0, 4.0, 2.0));
    assert_eq!((lamp.metallic, lamp.perceptual_roughness), (1.0, 1.0));
    let cloth = &scene.materials[&MaterialId(1)];
    assert_eq!(cloth.base_color, Vec4::new(0.5, 0.6, 0.7, 0.8));
    assert_eq!((cloth.metallic, cloth.perceptual_roughness), (0.25, 0.75));
    assert_eq!((cloth.alpha_mode, cloth.double_sided), (AlphaMode::Mask(0.25), true));
    let uv = cloth.uv_transform.transform_point2(Vec2::ONE);
    assert!(uv.distance(Vec2::new(2.5, 3.0)) < 1e-6, "{uv}");
    // One image in two colour spaces.
    assert_eq!(scene.textures.len(), 2);
    let texture = &scene.textures[&cloth.base_color_texture.unwrap()];
    assert_eq!((texture.width, texture.height, texture.srgb), (5, 3, true));
    assert_eq!(texture.texels[7], [200, 100, 50, 255]);
    assert!(!scene.textures[&cloth.metallic_roughness_texture.unwrap()].srgb);
}

#[test]
fn quantized_and_sparse_positions_are_read() {
    let imported = import(&rich());
    let (_, mesh) = imported.scene.meshes.iter().find(|(id, _)| id.0 & 1 == 1).unwrap();
    let expected = [[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]];
    assert_eq!(mesh.positions, expected.map(|p| Vec3::from(p.map(|v| v as f32))));
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
}

#[test]
fn lists_strips_fans_and_missing_indices_give_the_same_surface() {
    let normal = |mesh: &Mesh| {
        let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
        (b - a).cross(c - a).normalize()
    };
    for (mode, order, indexed) in [
        (4, vec![0, 1, 2, 0, 2, 3], true),
        (5, vec![0, 1, 3, 2], true),
        (6, vec![0, 1, 2, 3], true),
        (6, vec![0, 1, 2, 3], false),
    ] {
        let mut glb = Glb::new();
        let position = glb.floats(&SQUARE);
        let mut primitive = json!({"attributes": {"POSITION": position}, "mode": mode});
        if indexed {
            primitive["indices"] = glb.indices(&order).into();
        }
        glb.mesh(primitive);
        let imported = import(&glb);
        let mesh = only_mesh(&imported);
        assert_eq!(mesh.triangles.len(), 2, "mode {mode}");
        assert_eq!(normal(mesh), Vec3::Z, "mode {mode}");
        assert!(mesh.normals.is_empty() && mesh.uv0.is_empty() && mesh.uv1.is_empty());
        assert!(imported.scene.materials.contains_key(&DEFAULT_MATERIAL));
    }
}

#[test]
fn points_and_lines_are_left_out_with_a_warning() {
    for mode in 0..4 {
        let mut glb = square();
        glb.json["meshes"][0]["primitives"][0]["mode"] = mode.into();
        let imported = import(&glb);
        assert!(imported.scene.meshes.is_empty());
        assert!(imported.warnings[0].contains("no surface"), "{:?}", imported.warnings);
    }
}

#[test]
fn a_mesh_keeps_only_the_vertices_it_uses() {
    let mut glb = Glb::new();
    let mut positions = vec![[f32::NAN; 3]; 1000];
    positions.extend(SQUARE);
    let position = glb.floats(&positions);
    let indices = glb.indices(&SQUARE_INDICES.map(|i| i + 1000));
    glb.mesh(json!({"attributes": {"POSITION": position}, "indices": indices}));
    let imported = import(&glb);
    assert_eq!(imported.warnings, Vec::<String>::new());
    assert_eq!(only_mesh(&imported).positions, SQUARE.map(Vec3::from));
}

#[test]
fn the_materials_texture_coordinate_set_becomes_the_first() {
    let mut glb = rich();
    glb.json["materials"][0]["emissiveTexture"]["texCoord"] = 1.into();
    let other = glb.floats(&[[0.25, 0.25]; 4]);
    glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = other.into();
    let imported = import(&glb);
    let mesh = imported.scene.meshes.values().next().unwrap();
    assert_eq!(mesh.uv0, [Vec2::splat(0.25); 4]);
    assert_eq!(mesh.uv1, mesh.uv0);
}

#[test]
fn matrices_and_rotations_off_unit_length_are_understood() {
    let mut glb = square();
    glb.json["nodes"][0]["rotation"] = json!([0.0, 0.0, 1.4, 1.4]);
    let imported = import(&glb);
    let turned = imported.scene.instances[&InstanceId(0)].transform.transform_vector3(Vec3::X);
    assert!(turned.distance(Vec3::Y) < 1e-6, "{turned}");

    let mut glb = square();
    let s = FRAC_1_SQRT_2;
    glb.json["nodes"][0]["matrix"] = json!([s, s, 0, 0, -s, s, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1]);
    let transform = import(&glb).scene.instances[&InstanceId(0)].transform;
    assert_eq!(Vec3::from(transform.translation), Vec3::new(4.0, 5.0, 6.0));
}

#[test]
fn without_scenes_every_root_is_shown_once() {
    let mut glb = square();
    glb.push("nodes", json!({"children": [0], "translation": [0.0, 0.0, 5.0]}));
    let root = glb.json.as_object_mut().unwrap();
    root.remove("scene");
    root.remove("scenes");
    let imported = import(&glb);
    assert_eq!(imported.scene.instances.len(), 1);
    assert_eq!(imported.scene.instances[&InstanceId(0)].transform.translation.z, 5.0);
}

#[test]
fn gltf_files_find_their_buffers_below_their_folder() {
    let folder = std::env::temp_dir().join(format!("farlight-import-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("sub dir")).unwrap();
    let mut glb = square();
    std::fs::write(folder.join("sub dir/data.bin"), &glb.bin).unwrap();
    let read = |glb: &Glb, uri: &str| {
        let mut json = glb.json.clone();
        json["buffers"][0]["uri"] = uri.into();
        let path = folder.join("scene.gltf");
        std::fs::write(&path, json.to_string()).unwrap();
        load_scene(&path, &ImportOptions::default())
    };
    let imported = read(&glb, "sub%20dir/data.bin").unwrap();
    assert_eq!(only_mesh(&imported).positions, SQUARE.map(Vec3::from));

    let outside = folder.parent().unwrap().join(format!("outside-{}", std::process::id()));
    std::fs::write(&outside, &glb.bin).unwrap();
    let name = outside.file_name().unwrap().to_str().unwrap();
    for uri in [
        &format!("../{name}"),
        &format!("sub%20dir/../../{name}"),
        &format!("%2e%2e/{name}"),
        outside.to_str().unwrap(),
        "http://example.org/data.bin",
        "missing.bin",
        "..\\data.bin",
    ] {
        let error = read(&glb, uri).unwrap_err().to_string();
        assert!(error.contains("scene.gltf") && error.contains("refers to"), "{error}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&outside, folder.join("link.bin")).unwrap();
        let error = read(&glb, "link.bin").unwrap_err().to_string();
        assert!(error.contains("leads out"), "{error}");
    }
    // The whole file may be text.
    let uri =
        "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAA";
    glb = Glb::new();
    let position = glb.floats(&SQUARE[..3]);
    glb.mesh(json!({"attributes": {"POSITION": position}}));
    let imported = read(&glb, uri).unwrap();
    assert_eq!(only_mesh(&imported).positions, [SQUARE[0], SQUARE[1], SQUARE[2]].map(Vec3::from));
    std::fs::remove_dir_all(folder).unwrap();
    std::fs::remove_file(outside).unwrap();
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let missing = std::env::temp_dir().join("farlight-there-is-no-such-file.glb");
    let error = load_scene(&missing, &ImportOptions::default()).unwrap_err().to_string();
    assert!(error.contains("no-such-file.glb: cannot be read"), "{error}");
    let folder = load_scene(&std::env::temp_dir(), &ImportOptions::default());
    assert!(folder.is_err());

    // Two gigabytes of nothing: refused by its length, without being read.
    let path = std::env::temp_dir().join(format!("farlight-large-{}.glb", std::process::id()));
    std::fs::File::create(&path).and_then(|file| file.set_len(1 << 31)).unwrap();
    let (result, peak) = crate::memory::peak(|| load_scene(&path, &ImportOptions::default()));
    std::fs::remove_file(&path).unwrap();
    let error = result.unwrap_err().to_string();
    assert!(error.contains("ImportLimits::file_bytes") && peak < 1 << 20, "{error}, {peak}");
}
