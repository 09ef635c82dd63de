//! The configuration file.

use std::path::PathBuf;

use farlight::core::parse_ron;

use crate::{
    config::{self, Material, Model, Rig, Shape, Viewer},
    support,
};

fn file() -> PathBuf {
    support::assets().join("config/btf_viewer.ron")
}

#[test]
fn the_configuration_that_ships_is_the_default_and_names_every_field() {
    let text = std::fs::read_to_string(file()).unwrap();
    let config: Viewer = parse_ron("btf_viewer.ron", &text).unwrap();
    let default: Viewer = parse_ron("empty", "()").unwrap();
    let started = config::Start { material: String::new(), ..config.start.clone() };
    assert_eq!(Viewer { start: started, ..config.clone() }, default);
    for field in [
        "window",
        "resolution",
        "least",
        "scale",
        "greatest",
        "background",
        "camera",
        "position",
        "field_of_view",
        "screenshots",
        "base_scale",
        "base_offset",
        "models",
        "name",
        "shape",
        "uv_metres",
        "turn",
        "materials",
        "path",
        "size",
        "gain",
        "environments",
        "brightness",
        "progressive",
        "on",
        "lights",
        "per_frame",
        "shadows",
        "light",
        "illuminance",
        "direction",
        "exposure",
        "controls",
        "xr",
        "mode",
        "resolution_scale",
        "height",
        "distance",
        "start",
        "object",
        "material",
        "environment",
        "backdrop",
        "floor",
    ] {
        assert!(text.contains(&format!("{field}:")), "{field} is not in the file");
    }
    for model in &config.models {
        if let Shape::File(path) = &model.shape {
            assert!(support::assets().join(path).exists(), "{path}");
        }
    }
    for environment in &config.environments {
        assert!(support::assets().join(&environment.path).exists(), "{}", environment.path);
    }
}

#[test]
fn every_field_is_read() {
    let text = r#"Viewer(
        window: (800, 600),
        resolution: (least: 0.5, scale: 0.75, greatest: 1.5),
        background: (1, 2, 3),
        camera: (position: (0.0, 0.0, 3.5), field_of_view: 50.0),
        screenshots: "shots",
        base_scale: 2.0,
        base_offset: (0.1, 0.2, 0.3),
        models: [(name: "a", shape: File("a.glb"), uv_metres: 0.5, turn: 90.0)],
        materials: [(name: "m", path: "m.fbtf", size: Some((0.1, 0.2)), gain: 2.0)],
        environments: [(name: "e", path: "e.hdr", brightness: 125.0, turn: 10.0)],
        progressive: (on: false, lights: 64, per_frame: 3, shadows: false),
        light: (illuminance: 100.0, direction: (10.0, 20.0)),
        exposure: 7.0,
        controls: "mine.controls.ron",
        xr: (mode: Off, resolution_scale: 0.5, height: 1.0, distance: 2.0, size: None),
        start: (object: "a", material: "m", light: Five, environment: "e", backdrop: false, floor: false),
    )"#;
    let config: Viewer = parse_ron("a.viewer.ron", text).unwrap();
    assert_eq!(config.window, (800, 600));
    let model =
        Model { name: "a".into(), shape: Shape::File("a.glb".into()), uv_metres: 0.5, turn: 90.0 };
    assert_eq!(config.models, [model]);
    let material =
        Material { name: "m".into(), path: "m.fbtf".into(), size: Some((0.1, 0.2)), gain: 2.0 };
    assert_eq!(config.materials, [material]);
    assert_eq!(config.start.light, Rig::Five);
    // No field has its default: each was read from the text.
    let default = Viewer::default();
    assert!(config.resolution != default.resolution && config.background != default.background);
    assert!(config.camera != default.camera && config.screenshots != default.screenshots);
    assert!(config.base_scale != default.base_scale && config.base_offset != default.base_offset);
    assert!(config.environments != default.environments && config.light != default.light);
    assert!(config.progressive.lights == 64 && config.progressive.per_frame == 3);
    assert!(!config.progressive.on && !config.progressive.shadows);
    assert!(config.controls != default.controls);
    let (xr, usual) = (config.xr, default.xr);
    assert!(xr.mode != usual.mode && xr.resolution_scale != usual.resolution_scale);
    assert!(xr.height != usual.height && xr.distance != usual.distance && xr.size != usual.size);
    assert!(config.exposure != default.exposure && config.start != default.start);
}

#[test]
fn mistakes_are_named_with_file_line_and_field() {
    let error = |text: &str| parse_ron::<Viewer>("v.ron", text).unwrap_err().to_string();
    let unknown = error("Viewer(\n    exposure: 9.0,\n    use_vr: true,\n)");
    assert!(unknown.starts_with("v.ron:3:") && unknown.contains("use_vr"), "{unknown}");
    let range = error("Viewer(\n    base_scale: 0.0,\n)");
    assert!(range.starts_with("v.ron:2: base_scale: "), "{range}");
    let model = "(name: \"a\", shape: Sphere";
    let listed = error(&format!(
        "Viewer(\n    models: [\n        {model}),\n        {model}, uv_metres: 0.0),\n    ],\n)"
    ));
    assert!(listed.starts_with("v.ron:4: models[1].uv_metres: "), "{listed}");
    let name = error("Viewer(start: (object: \"cat\"))");
    assert!(name.contains("cat") && name.contains("bunny"), "{name}");
    assert!(error("Viewer(models: [])").contains("at least one"));
}
