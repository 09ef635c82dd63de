//! The demo's scene: readable without a warning, closed, and made for a lightmap.

use std::path::{Path, PathBuf};

use farlight_gi_solver::{
    Ray, World,
    import::{ImportOptions, ImportedScene, load_scene},
};
use glam::Vec3;

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/scenes/doorway.glb")
}

fn doorway() -> ImportedScene {
    load_scene(&path(), &ImportOptions::default()).expect("the committed scene is readable")
}

/// Bevy reads glTF files with the crate `gltf`, whose validation is stricter than our importer.
#[test]
fn it_is_valid_for_the_reader_that_bevy_uses() {
    let file = gltf::Gltf::from_slice(&std::fs::read(path()).unwrap()).unwrap();
    for mesh in file.meshes() {
        for primitive in mesh.primitives() {
            let reader = primitive.reader(|_| file.blob.as_deref());
            assert!(reader.read_tex_coords(1).is_some(), "{:?}", mesh.name());
            let bounds = primitive.bounding_box();
            for p in reader.read_positions().unwrap() {
                let inside = (0..3).all(|k| (bounds.min[k]..=bounds.max[k]).contains(&p[k]));
                assert!(inside, "{:?}", mesh.name());
            }
        }
    }
}

#[test]
fn it_is_read_without_a_warning() {
    let imported = doorway();
    assert_eq!(imported.warnings, Vec::<String>::new());
    let scene = &imported.scene;
    assert!((8..=14).contains(&scene.instances.len()), "{} instances", scene.instances.len());
    assert!(imported.light_ids.is_empty(), "the demo brings its own light");
    for mesh in scene.meshes.values() {
        mesh.validate().unwrap();
        assert_eq!(mesh.uv1.len(), mesh.positions.len());
        assert_eq!(mesh.normals.len(), mesh.positions.len());
    }
    assert!(scene.materials.values().all(|m| m.metallic == 0.0));
    assert_eq!(scene.textures.len(), 9);
}

/// From anywhere in the two rooms every ray ends on the front of a surface.
#[test]
fn no_light_gets_in_or_out() {
    let world = World::new(&doorway().scene);
    let mut state = 1_u64;
    let mut random = || {
        // PCG's multiplier and increment; the high bits are good.
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1_u64 << 24) as f32
    };
    // Places in the air: in the bright room, in the dark one, in the doorway.
    let origins = [Vec3::new(-2.6, 2.1, 0.6), Vec3::new(2.2, 1.6, 0.6), Vec3::new(0.0, 1.0, 0.6)];
    let (mut escaped, mut back) = (0, 0);
    for i in 0..300_000 {
        let (z, angle) = (2.0 * random() - 1.0, std::f32::consts::TAU * random());
        let r = (1.0 - z * z).sqrt();
        let direction = Vec3::new(r * angle.cos(), r * angle.sin(), z);
        let jitter = Vec3::new(random(), random(), random()) * 0.1;
        let hit = world.tracer.closest(&Ray::new(origins[i % 3] + jitter, direction));
        escaped += u32::from(!hit.is_hit());
        back += u32::from(hit.is_hit() && world.surface(&hit, direction).back);
    }
    assert_eq!((escaped, back), (0, 0), "rays that escape, rays that meet a back side");
}
