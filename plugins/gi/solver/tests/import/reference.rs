//! Reads the reference scenes and a real interior. Needs `FARLIGHT_TEST_DATA`.

use std::path::PathBuf;

use farlight_gi_solver::{
    import::{ImportOptions, load_scene},
    scene::LightKind,
};
use glam::Vec3;

fn data(file: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("FARLIGHT_TEST_DATA") else {
        println!("skipped: FARLIGHT_TEST_DATA does not name the folder with the test data");
        return None;
    };
    Some(PathBuf::from(folder).join(file))
}

#[test]
fn cornell_box_is_read_whole() {
    let Some(path) = data("reference/CornellBox.glb") else { return };
    let imported = load_scene(&path, &ImportOptions::default()).unwrap();
    assert_eq!(imported.warnings, Vec::<String>::new());
    let scene = &imported.scene;
    assert_eq!((scene.meshes.len(), scene.instances.len(), scene.materials.len()), (5, 5, 4));
    assert!(scene.meshes.values().all(|m| m.validate().is_ok() && !m.uv1.is_empty()));
    let lights: Vec<_> = imported.light_ids.iter().map(|id| scene.lights[id]).collect();
    assert_eq!(lights.len(), 2);
    assert_eq!(lights[0].kind, LightKind::Point);
    assert!(lights[0].position.distance(Vec3::new(-2.78, 4.2, -2.795)) < 1e-6);
    assert!(lights[0].intensity.distance(Vec3::new(40.0, 36.0, 30.0)) < 1e-4);
    assert!(lights[0].range.is_infinite());
    assert_eq!(lights[1].kind, LightKind::Directional);
    assert!(lights[1].direction.is_normalized() && lights[1].direction.y < -0.5);
}

#[test]
fn two_rooms_is_read_whole() {
    let Some(path) = data("reference/TwoRooms.glb") else { return };
    let options = ImportOptions { range_window: true, ..Default::default() };
    let imported = load_scene(&path, &options).unwrap();
    assert_eq!(imported.warnings, Vec::<String>::new());
    assert_eq!(imported.light_ids.len(), 1);
    assert_eq!(imported.scene.lights[&imported.light_ids[0]].range, 20.0);
}

#[test]
fn hotel_room_leaves_its_lines_out() {
    let Some(path) = data("scenes/hotel-room.glb") else { return };
    let options = ImportOptions { scale: 0.001, ..Default::default() };
    let start = std::time::Instant::now();
    let (imported, peak) = crate::memory::peak(|| load_scene(&path, &options).unwrap());
    println!("read in {:?}, {:.1} MB at most", start.elapsed(), peak as f64 / 1e6);
    let scene = &imported.scene;
    let triangles: usize = scene.meshes.values().map(|m| m.triangles.len()).sum();
    println!("{triangles} triangles, {:#?}", imported.warnings);
    assert!(imported.warnings.iter().any(|w| w.contains("Lines")));
    assert!((98_000..=99_029).contains(&triangles), "{triangles}");
    assert_eq!(scene.textures.len(), 6);
    let points = scene.meshes.values().flat_map(|m| &m.positions);
    let (low, high) =
        points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    assert!((high - low).max_element() < 20.0, "millimetres become metres: {low} {high}");
}
