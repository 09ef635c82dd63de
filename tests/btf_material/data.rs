//! Files, buffers and devices.

use std::path::{Path, PathBuf};

use bevy::{pbr::RenderMaterialBindings, platform::collections::HashSet, render::RenderApp};
use farlight::btf::BtfSettings;

use crate::*;

/// `count` squares side by side, each of a colour of its own.
fn colours(stage: &mut Stage, count: u32) -> Vec<Vec3> {
    let width = 2.0 / count as f32;
    let square = stage.mesh(Rectangle::new(width, 2.0));
    (0..count)
        .map(|i| {
            let share = (i as f32 + 0.5) / count as f32;
            let colour = Vec3::new(0.1 + 0.8 * share, 0.5, 0.9 - 0.8 * share);
            let btf = synthetic::lambert(colour.to_array(), [2, 2]).unwrap();
            let btf = stage.btf(btf);
            let material = stage.material(BtfMaterial::new(btf));
            // More squares stand before fewer, not in the same plane.
            let depth = 1e-3 * count as f32;
            let place = Transform::from_xyz(width * (i as f32 + 0.5) - 1.0, 0.0, depth);
            stage.spawn((Mesh3d(square.clone()), material, place));
            colour
        })
        .collect()
}

fn assert_colours(stage: &mut Stage, colours: &[Vec3]) {
    let pixels = stage.floats();
    for (i, colour) in colours.iter().enumerate() {
        let x = (i as f32 + 0.5) / colours.len() as f32 * SIZE as f32;
        let found = at(&pixels, x as u32, SIZE / 2);
        let off = (found - *colour).abs().max_element();
        assert!(off < 0.005, "square {i}: {found} instead of {colour}");
    }
}

fn groups(stage: &mut Stage) -> usize {
    let materials: Vec<_> = stage.world().resource::<Assets<BtfMaterial>>().ids().collect();
    let bindings =
        stage.headless.app.sub_app(RenderApp).world().resource::<RenderMaterialBindings>();
    let groups: HashSet<u32> = materials
        .iter()
        .filter_map(|id| bindings.get(&id.untyped()))
        .map(|binding| binding.group.0)
        .collect();
    groups.len()
}

#[test]
fn ten_materials_share_a_buffer_and_a_bind_group() {
    let mut stage = Stage::new();
    stage.light_in_front();
    let expected = colours(&mut stage, 10);
    stage.settle();
    assert_colours(&mut stage, &expected);
    let status = stage.world().resource::<BtfStatus>().clone();
    assert_eq!((status.resident, status.buffers), (10, 1), "{status:?}");
    assert_eq!(groups(&mut stage), 1);
    // More come later: the buffer grows, those that are there stay.
    let more = colours(&mut stage, 16);
    stage.settle();
    assert_colours(&mut stage, &more);
    assert_eq!(groups(&mut stage), 1);
    // All go.
    let objects: Vec<Entity> = stage
        .world()
        .query_filtered::<Entity, With<MeshMaterial3d<BtfMaterial>>>()
        .iter(stage.headless.app.world())
        .collect();
    for object in objects {
        stage.world().despawn(object);
    }
    for _ in 0..6 {
        stage.headless.update().unwrap();
    }
    let status = stage.world().resource::<BtfStatus>().clone();
    assert_eq!((status.resident, status.resident_bytes, status.buffers), (0, 0, 0), "{status:?}");
    // And others come in their place.
    let again = colours(&mut stage, 5);
    stage.settle();
    assert_colours(&mut stage, &again);
}

#[test]
fn a_full_buffer_is_followed_by_another() {
    let mut stage = Stage::new();
    stage.light_in_front();
    // Each material takes about 0.8 MB.
    stage.world().resource_mut::<BtfSettings>().max_buffer_bytes = 2 << 20;
    let expected = colours(&mut stage, 6);
    stage.settle();
    assert_colours(&mut stage, &expected);
    let status = stage.world().resource::<BtfStatus>().clone();
    assert!(status.buffers > 1 && status.resident == 6, "{status:?}");
    assert_eq!(groups(&mut stage), status.buffers);
}

#[test]
fn what_fits_into_no_buffer_is_refused_and_the_rest_goes_on() {
    let mut stage = Stage::new();
    stage.light_in_front();
    stage.world().resource_mut::<BtfSettings>().max_buffer_bytes = 1 << 20;
    let expected = colours(&mut stage, 1);
    let large = synthetic::lambert([1.0; 3], [600, 600]).unwrap();
    let btf = stage.btf(large);
    let material = stage.material(BtfMaterial::new(btf));
    let square = stage.mesh(Rectangle::new(1.0, 1.0));
    stage.spawn((Mesh3d(square), material));
    stage.settle();
    assert_colours(&mut stage, &expected);
    let status = stage.world().resource::<BtfStatus>().clone();
    assert_eq!(status.failed.len(), 1, "{status:?}");
}

#[test]
fn settings_reach_materials_that_are_there() {
    let mut stage = Stage::new();
    stage.float_camera(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 2.0);
    stage.world().resource_mut::<GlobalAmbientLight>().brightness = 1.0;
    let btf = stage.btf(orientation::uneven());
    let material = stage.material(BtfMaterial::new(btf));
    let square = stage.mesh(Rectangle::new(2.0, 2.0));
    stage.spawn((Mesh3d(square), material));
    stage.settle();
    let before = stage.floats();
    stage.world().resource_mut::<BtfSettings>().albedo_directions = 1;
    let after = stage.floats();
    assert!(before[0] != Vec3::ZERO && before != after, "the setting changed nothing");
}

/// A folder of files of its own for a test.
fn folder(name: &str) -> PathBuf {
    let folder = support::scratch(&format!("btf_material/{name}"));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn write(folder: &Path, name: &str, colour: [f32; 3]) {
    synthetic::lambert(colour, [2, 2]).unwrap().write(&folder.join(name)).unwrap();
}

fn stage_with_files(folder: &Path) -> Stage {
    let headless = Headless::new(UVec2::splat(SIZE), folder, |app| {
        app.add_plugins(FarlightPlugins)
            .insert_resource(GlobalAmbientLight::NONE)
            .insert_resource(ClearColor(Color::BLACK));
    });
    Stage::of(headless.unwrap_or_else(|problem| panic!("{problem}")))
}

fn show(stage: &mut Stage, file: &'static str) {
    let btf = stage.world().resource::<AssetServer>().load(file);
    let material = stage.material(BtfMaterial::new(btf));
    let square = stage.mesh(Rectangle::new(2.0, 2.0));
    stage.spawn((Mesh3d(square), material));
}

#[test]
fn a_file_that_changes_is_shown_anew() {
    let folder = folder("reload");
    let (red, blue) = (Vec3::new(0.8, 0.1, 0.1), Vec3::new(0.1, 0.1, 0.8));
    write(&folder, "a.fbtf", red.to_array());
    let mut stage = stage_with_files(&folder);
    stage.light_in_front();
    show(&mut stage, "a.fbtf");
    stage.settle();
    assert_colours(&mut stage, &[red]);
    let reload = |stage: &mut Stage| {
        stage.world().resource::<AssetServer>().reload("a.fbtf");
        for _ in 0..40 {
            stage.headless.update().unwrap();
            std::thread::sleep(Duration::from_millis(5));
        }
        stage.settle();
    };
    write(&folder, "a.fbtf", blue.to_array());
    reload(&mut stage);
    assert_colours(&mut stage, &[blue]);
    // A damaged one is reported, the last good one stays.
    std::fs::write(folder.join("a.fbtf"), b"nothing of the kind").unwrap();
    reload(&mut stage);
    assert_colours(&mut stage, &[blue]);
    assert_eq!(stage.world().resource::<BtfStatus>().failed.len(), 1);
    write(&folder, "a.fbtf", red.to_array());
    reload(&mut stage);
    assert_colours(&mut stage, &[red]);
    assert!(stage.world().resource::<BtfStatus>().failed.is_empty());
}

#[test]
fn a_damaged_file_is_reported_and_the_rest_goes_on() {
    let folder = folder("damaged");
    let green = Vec3::new(0.1, 0.7, 0.1);
    write(&folder, "good.fbtf", green.to_array());
    let mut bytes = std::fs::read(folder.join("good.fbtf")).unwrap();
    bytes.truncate(bytes.len() / 2);
    std::fs::write(folder.join("cut.fbtf"), bytes).unwrap();
    let mut stage = stage_with_files(&folder);
    stage.light_in_front();
    show(&mut stage, "cut.fbtf");
    show(&mut stage, "missing.fbtf");
    show(&mut stage, "good.fbtf");
    stage.settle();
    assert_colours(&mut stage, &[green]);
    let mut failed = stage.world().resource::<BtfStatus>().failed.clone();
    failed.sort_by(|a, b| a.path.cmp(&b.path));
    let paths: Vec<_> = failed.iter().map(|failure| failure.path.as_str()).collect();
    assert_eq!(paths, ["cut.fbtf", "missing.fbtf"], "{failed:?}");
}
