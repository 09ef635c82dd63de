//! Which second UV sets are kept, cropped, made, or refused; and that they are good.

use std::{
    collections::BTreeMap,
    sync::{
        Mutex,
        atomic::{AtomicU32, Ordering},
    },
};

use farlight_baked_format::Fingerprint;
use farlight_baker::{
    gltf::write,
    uv::{Cancelled, NoCache, SecondSet, UvCache, UvOptions, UvSet, density_for, second_sets},
};
use farlight_gi_solver::{
    World,
    bake::{Density, Layout, LayoutSettings},
    import::ImportOptions,
    scene::{InstanceId, Mesh, MeshId},
    unwrap::{charts, check_uv1, coverage, density, gutter},
};
use glam::{UVec2, Vec2, Vec3};
use serde_json::{Value, json};

use crate::{
    glb::Glb,
    whole::{Sets, open, same, sets_of},
};

/// Vertices of a primitive.
#[derive(Clone, Default)]
struct Shape {
    places: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uv1: Vec<[f32; 2]>,
    triangles: Vec<u32>,
}

impl Shape {
    /// A rectangle with its corners' second UVs.
    fn quad(&mut self, corners: [[f32; 3]; 4], low: [f32; 2], high: [f32; 2]) {
        let first = self.places.len() as u32;
        let [a, b, _, d] = corners.map(Vec3::from);
        let normal = (b - a).cross(d - a).normalize();
        self.places.extend(corners);
        self.normals.extend([normal.to_array(); 4]);
        self.uv1.extend([low, [high[0], low[1]], high, [low[0], high[1]]]);
        self.triangles.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
    }

    /// Floor of 4 x 2 m and wall of 4 x 1 m, with charts of the given density in their square.
    fn corner(floor: f32, wall: f32, gap: f32) -> Self {
        let mut shape = Self::default();
        let low = [0.1, 0.1];
        let high = [0.1 + 4.0 * floor, 0.1 + 2.0 * floor];
        let places = [[0.0, 0.0, 2.0], [4.0, 0.0, 2.0], [4.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
        shape.quad(places, low, high);
        let low = [0.1, high[1] + gap];
        let high = [0.1 + 4.0 * wall, low[1] + wall];
        let places = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        shape.quad(places, low, high);
        shape
    }

    fn primitive(&self, glb: &mut Glb, uv1: bool) -> Value {
        let mut attributes = json!({"POSITION": glb.floats(&self.places)});
        if !self.normals.is_empty() {
            attributes["NORMAL"] = glb.floats(&self.normals).into();
        }
        if uv1 {
            let set = glb.floats(&self.uv1);
            attributes["TEXCOORD_0"] = set.into();
            attributes["TEXCOORD_1"] = set.into();
        }
        let indices: Vec<u8> = self.triangles.iter().map(|&i| i as u8).collect();
        json!({"attributes": attributes, "indices": glb.bytes_of(&indices, "SCALAR", indices.len())})
    }

    /// A file with this as its only mesh, in one node.
    fn file(&self, uv1: bool, node: Value) -> Glb {
        let mut glb = Glb::new();
        let primitive = self.primitive(&mut glb, uv1);
        glb.push("meshes", json!({"primitives": [primitive]}));
        let mut node = node;
        node["mesh"] = 0.into();
        glb.node(node);
        glb
    }
}

/// Writes, reads, and checks what must always hold; the mesh and its set.
fn baked(glb: &Glb, options: &UvOptions) -> (Mesh, SecondSet) {
    let source = open(glb);
    let (imported, sets) = sets_of(&source, options, 1.0);
    same(&write(&source, &sets, 1.0).unwrap(), &imported, &sets);
    let mesh = Mesh::clone(&imported.scene.meshes[&MeshId(0)]);
    (mesh, sets[&MeshId(0)].clone())
}

/// The size of the only instance.
fn size(set: &SecondSet) -> UVec2 {
    *set.sizes.values().next().unwrap()
}

fn bounds(mesh: &Mesh) -> [Vec2; 2] {
    let first = [Vec2::INFINITY, Vec2::NEG_INFINITY];
    mesh.uv1.iter().fold(first, |[low, high], &uv| [low.min(uv), high.max(uv)])
}

/// Margins at the four borders of the square, in texels: those at left and top, those at right and
/// bottom.
fn margins(mesh: &Mesh, size: UVec2) -> [Vec2; 2] {
    let [low, high] = bounds(mesh);
    [low * size.as_vec2(), (Vec2::ONE - high) * size.as_vec2()]
}

fn reason(set: &SecondSet) -> &str {
    match &set.set {
        UvSet::Made { why, .. } => why,
        UvSet::None { reason } => reason,
        other => panic!("{other:?}"),
    }
}

const OPTIONS: UvOptions = UvOptions { texels_per_metre: 20.0, padding: 2, max_texels: 1024 };

#[test]
fn a_good_set_is_cropped_and_keeps_its_charts() {
    let (mesh, set) = baked(&Shape::corner(0.1, 0.1, 0.1).file(true, json!({})), &OPTIONS);
    assert!(matches!(set.set, UvSet::Cropped { .. }), "{:?}", set.set);
    // 4 x 4 m with the gap of a metre, and a texel at each border.
    assert_eq!(size(&set), UVec2::new(82, 82));
    let [low, high] = margins(&mesh, size(&set));
    assert!(low.distance(Vec2::ONE) < 1e-3 && high.distance(Vec2::ONE) < 1e-3, "{low} {high}");
    assert!((set.texels_per_metre - 20.0).abs() < 1e-3, "{}", set.texels_per_metre);
    assert!(density(&mesh, size(&set)).spread() < 1.001);
    assert_eq!(set.gutter, 2.0);
}

#[test]
fn what_was_baked_is_kept_when_it_is_baked_again() {
    let glb = Shape::corner(0.1, 0.1, 0.1).file(true, json!({}));
    let source = open(&glb);
    let (_, sets) = sets_of(&source, &OPTIONS, 1.0);
    let bytes = write(&source, &sets, 1.0).unwrap();
    let again = farlight_baker::gltf::Source::from_slice(&bytes, &Default::default()).unwrap();
    let (_, kept) = sets_of(&again, &OPTIONS, 1.0);
    assert_eq!(kept[&MeshId(0)].set, UvSet::Kept);
    assert_eq!(kept[&MeshId(0)].sizes, sets[&MeshId(0)].sizes);
    assert_eq!(write(&again, &kept, 1.0).unwrap(), bytes);
}

#[test]
fn primitives_that_share_a_square_get_their_own() {
    // As exporters write an object with two materials.
    let whole = Shape::corner(0.1, 0.1, 0.1);
    let part = |range: std::ops::Range<usize>| Shape {
        places: whole.places[range.clone()].to_vec(),
        normals: whole.normals[range.clone()].to_vec(),
        uv1: whole.uv1[range].to_vec(),
        triangles: vec![0, 1, 2, 0, 2, 3],
    };
    let mut glb = Glb::new();
    let primitives: Vec<Value> =
        [part(0..4), part(4..8)].iter().map(|part| part.primitive(&mut glb, true)).collect();
    glb.push("meshes", json!({"primitives": primitives}));
    glb.node(json!({"mesh": 0}));
    let source = open(&glb);
    let (imported, sets) = sets_of(&source, &OPTIONS, 1.0);
    same(&write(&source, &sets, 1.0).unwrap(), &imported, &sets);
    for (id, expected) in [(0, UVec2::new(82, 42)), (1, UVec2::new(82, 22))] {
        let set = &sets[&MeshId(id)];
        assert!(matches!(set.set, UvSet::Cropped { .. }), "{:?}", set.set);
        assert_eq!(size(set), expected);
        let [low, high] = margins(&imported.scene.meshes[&MeshId(id)], expected);
        assert!(low.distance(Vec2::ONE) < 1e-3 && high.distance(Vec2::ONE) < 1e-3);
    }
}

#[test]
fn sets_that_cannot_hold_a_lightmap_are_replaced_and_it_is_said_why() {
    let good = Shape::corner(0.1, 0.1, 0.1);
    let mut tiling = good.clone();
    tiling.uv1.iter_mut().for_each(|uv| uv[0] *= 3.0);
    let mut collapsed = good.clone();
    collapsed.uv1[4..].fill([0.5; 2]);
    let overlapping = Shape::corner(0.1, 0.1, -0.1);
    let uneven = Shape::corner(0.1, 0.01, 0.1);
    let mut touching = Shape::corner(0.1, 0.1, 0.0);
    touching.uv1[4..].iter_mut().for_each(|uv| uv[0] += 0.05);
    for (shape, uv1, word) in [
        (good, false, "no second UV set"),
        (tiling, true, "leaves the unit square"),
        (collapsed, true, "no area"),
        (overlapping, true, "overlaps itself"),
        (uneven, true, "10 times as many texels"),
        (touching, true, "0.0 texels apart"),
    ] {
        let (mesh, set) = baked(&shape.file(uv1, json!({})), &OPTIONS);
        assert!(reason(&set).contains(word), "{word}: {}", reason(&set));
        assert!(matches!(set.set, UvSet::Made { .. }));
        let size = size(&set);
        assert_eq!(check_uv1(&mesh, 1024), Ok(()), "{word}");
        let found = density(&mesh, size);
        assert!(found.spread() < 1.01 && (found.p50 - 20.0).abs() < 0.1, "{word}: {found:?}");
        assert!(gutter(&mesh, &charts(&mesh), size, 3.0) >= 1.99, "{word}");
        let [low, high] = margins(&mesh, size);
        assert!(low.min(high).min_element() >= 0.99, "{word}: {low} {high}");
        // 12 m² of 20 x 20 texels, and not much air.
        assert!(size.element_product() < 8000 && coverage(&mesh) > 0.6, "{word}: {size}");
    }
}

#[test]
fn a_set_that_places_textures_stays_or_there_is_no_lightmap() {
    let material =
        json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}}}]);
    let with = |shape: &Shape| {
        let mut glb = shape.file(true, json!({}));
        glb.json["materials"] = material.clone();
        glb.json["textures"] = json!([{}]);
        glb.json["meshes"][0]["primitives"][0]["material"] = 0.into();
        glb
    };
    let good = Shape::corner(0.1, 0.05, 0.1);
    let (mesh, set) = baked(&with(&good), &OPTIONS);
    assert_eq!(set.set, UvSet::Kept);
    assert_eq!(mesh.uv1, good.uv1.iter().map(|&uv| Vec2::from(uv)).collect::<Vec<_>>());
    assert_eq!(size(&set), UVec2::splat(200));
    // The engine makes flat normals by splitting vertices; the values stay.
    let mut flat = good.clone();
    flat.normals.clear();
    let (mesh, set) = baked(&with(&flat), &OPTIONS);
    assert!(matches!(set.set, UvSet::Cropped { .. }));
    assert_eq!(mesh.uv1[5], Vec2::from(good.uv1[3]));

    let (mesh, set) = baked(&with(&Shape::corner(0.1, 0.1, -0.1)), &OPTIONS);
    assert!(reason(&set).contains("TEXCOORD_1") && reason(&set).contains("overlaps"), "{set:?}");
    assert!(mesh.uv1.is_empty() && set.sizes.is_empty());
}

#[test]
fn what_a_skeleton_moves_has_no_lightmap() {
    let mut glb = Shape::corner(0.1, 0.1, 0.1).file(true, json!({}));
    glb.json["skins"] = json!([{"joints": [0]}]);
    glb.json["nodes"][0]["skin"] = 0.into();
    let (_, set) = baked(&glb, &OPTIONS);
    assert!(reason(&set).contains("skeleton"), "{set:?}");
}

#[test]
fn texels_are_for_metres_of_the_largest_instance_whichever_way_it_is_scaled() {
    // The largest is mirrored and stretched; the two charts' own metres do not matter.
    let shape = Shape::corner(0.1, 0.1, 0.1);
    let mut glb = shape.file(false, json!({}));
    glb.node(json!({"mesh": 0, "scale": [-1.0, 8.0, 1.0], "translation": [9.0, 0.0, 0.0]}));
    glb.node(json!({"mesh": 0, "scale": [0.01, 0.01, 0.01]}));
    let source = open(&glb);
    let (imported, sets) = sets_of(&source, &OPTIONS, 1.0);
    same(&write(&source, &sets, 1.0).unwrap(), &imported, &sets);
    let set = &sets[&MeshId(0)];
    let mut stretched = Mesh::clone(&imported.scene.meshes[&MeshId(0)]);
    stretched.positions.iter_mut().for_each(|p| p.y *= 8.0);
    let sizes: Vec<UVec2> = set.sizes.values().copied().collect();
    let found = density(&stretched, sizes[1]);
    assert!(found.spread() < 1.01 && (found.p50 - 20.0).abs() < 0.2, "{found:?}");
    assert!(sizes[0].x < sizes[1].x && sizes[0].x > sizes[1].x / 2, "{sizes:?}");
    // A tiny one keeps half of the edges, so that gutters hold.
    assert_eq!(sizes[2], (sizes[1].as_vec2() / 2.0).round().as_uvec2());
    assert_eq!(set.gutter, 2.0);
    let charts = charts(&imported.scene.meshes[&MeshId(0)]);
    assert!(gutter(&stretched, &charts, sizes[2], 4.0) >= 1.9);
}

#[test]
fn mirrored_instances_are_lit_from_their_front() {
    let mut glb = Shape::corner(0.1, 0.1, 0.1).file(false, json!({}));
    glb.node(json!({"mesh": 0, "scale": [-1.0, 1.0, 1.0], "translation": [20.0, 0.0, 0.0]}));
    let source = open(&glb);
    let (_, sets) = sets_of(&source, &OPTIONS, 1.0);
    let bytes = write(&source, &sets, 1.0).unwrap();
    let scene =
        farlight_gi_solver::import::load_scene_from_slice(&bytes, &ImportOptions::default())
            .unwrap()
            .scene;
    let world = World::new(&scene);
    let settings =
        LayoutSettings { page_size: 256, max_pages: 1, density: Density::TexelsPerMetre(20.0) };
    let layout = Layout::new(&scene, &world, scene.instances.keys().copied(), &settings);
    let mut found: BTreeMap<InstanceId, Vec<(Vec3, Vec3)>> = BTreeMap::new();
    for texel in layout.texels() {
        let up = texel.position.y < 1e-4 && texel.position.z > 1e-4;
        let expected = if up { Vec3::Y } else { Vec3::Z };
        assert!(texel.normal.distance(expected) < 1e-3, "{texel:?}");
        found.entry(texel.instance).or_default().push((texel.position, texel.normal));
    }
    // The same texels, mirrored.
    let [plain, mirrored] = [0, 1].map(|i: u64| &found[&InstanceId(i << 32)]);
    assert!(plain.len() > 4000);
    assert_eq!(plain.len(), mirrored.len());
    for ((a, _), (b, _)) in plain.iter().zip(mirrored) {
        let b = Vec3::new(20.0 - b.x, b.y, b.z);
        assert!(a.distance(b) < 1e-3, "{a} {b}");
    }
}

#[test]
fn flat_faces_get_the_vertices_that_the_engine_will_give_them() {
    let mut shape = Shape::corner(0.1, 0.1, 0.1);
    shape.normals.clear();
    for uv1 in [false, true] {
        let (mesh, _) = baked(&shape.file(uv1, json!({})), &OPTIONS);
        assert_eq!(mesh.positions.len(), 12);
    }
}

#[test]
fn more_texels_than_a_page_has_are_not_handed_out() {
    let options = UvOptions { texels_per_metre: 1e9, max_texels: 64, ..OPTIONS };
    for uv1 in [false, true] {
        let (mesh, set) = baked(&Shape::corner(0.1, 0.1, 0.1).file(uv1, json!({})), &options);
        assert!(size(&set).max_element() <= 64 && size(&set).max_element() >= 60, "{set:?}");
        assert!(set.texels_per_metre > 10.0);
        assert_eq!(check_uv1(&mesh, 256), Ok(()));
    }
    let options = UvOptions { texels_per_metre: 0.0, ..options };
    let (_, set) = baked(&Shape::corner(0.1, 0.1, 0.1).file(false, json!({})), &options);
    assert!(size(&set).max_element() <= 16, "{set:?}");
}

#[test]
fn a_wider_gutter_for_mips() {
    let options = UvOptions { padding: 8, ..OPTIONS };
    let (mesh, set) = baked(&Shape::corner(0.1, 0.1, 0.1).file(false, json!({})), &options);
    let size = size(&set);
    assert!(gutter(&mesh, &charts(&mesh), size, 9.0) >= 7.99);
    let [low, high] = margins(&mesh, size);
    assert!(low.min(high).min_element() >= 3.99, "{low} {high}");
    assert_eq!(set.gutter, 8.0);
}

#[derive(Default)]
struct Memory(Mutex<BTreeMap<Fingerprint, Vec<u8>>>, AtomicU32);

impl UvCache for Memory {
    fn get(&self, key: Fingerprint) -> Option<Vec<u8>> {
        let found = self.0.lock().unwrap().get(&key).cloned();
        self.1.fetch_add(u32::from(found.is_some()), Ordering::Relaxed);
        found
    }

    fn put(&self, key: Fingerprint, bytes: &[u8]) {
        self.0.lock().unwrap().insert(key, bytes.to_vec());
    }
}

#[test]
fn a_cache_gives_the_same_and_a_damaged_one_does_no_harm() {
    let source = open(&Shape::corner(0.1, 0.1, 0.1).file(false, json!({})));
    let imported = source.scene(&ImportOptions::default()).unwrap();
    let memory = Memory::default();
    let ask = |options: &UvOptions| -> Sets {
        second_sets(&imported, &source, options, &memory, &|_, _| true).unwrap()
    };
    let first = ask(&OPTIONS);
    assert_eq!(memory.1.load(Ordering::Relaxed), 0);
    assert_eq!(ask(&OPTIONS), first);
    assert_eq!(memory.1.load(Ordering::Relaxed), 1);
    assert_ne!(ask(&UvOptions { padding: 4, ..OPTIONS }), first);
    for bytes in memory.0.lock().unwrap().values_mut() {
        bytes[40] ^= 1;
    }
    assert_eq!(ask(&OPTIONS), first);
}

#[test]
fn it_can_be_stopped() {
    let source = open(&Shape::corner(0.1, 0.1, 0.1).file(false, json!({})));
    let imported = source.scene(&ImportOptions::default()).unwrap();
    let sets = second_sets(&imported, &source, &OPTIONS, &NoCache, &|_, _| false);
    assert_eq!(sets, Err(Cancelled));
}

#[test]
fn the_density_for_a_page() {
    let source = open(&Shape::corner(0.1, 0.1, 0.1).file(false, json!({"scale": [2.0, 2.0, 2.0]})));
    let imported = source.scene(&ImportOptions::default()).unwrap();
    let density = density_for(&imported, 10_000.0);
    assert!((density - (6000.0_f32 / 48.0).sqrt()).abs() < 1e-3, "{density}");
}
