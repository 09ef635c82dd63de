//! The viewer of measured materials, as a person runs it without a window, only smaller.

#[path = "../examples/btf_viewer/config.rs"]
#[expect(dead_code, unreachable_pub, reason = "shared with the example")]
mod config;
mod support;

use std::{
    path::PathBuf,
    process::{Command, Output},
    thread,
};

use config::{Material, Model, Rig, Shape, Viewer};
use farlight::core::parse_ron;
use farlight_btf_codec::synthetic;
use support::{
    example::{difference, load, program, words},
    headless::Picture,
};

fn viewer(arguments: &[&str]) -> Output {
    Command::new(program("btf_viewer")).args(arguments).output().unwrap()
}

/// A material file: bright, without a direction of its own.
fn material() -> String {
    let path = support::scratch("btf_viewer").join(format!("{:?}.fbtf", thread::current().id()));
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    synthetic::lambert([0.8, 0.7, 0.5], [2, 2]).unwrap().write(&path).unwrap();
    path.display().to_string()
}

/// Runs a turntable of four pictures, 96 x 72, and checks what must hold for any of them.
fn turntable(name: &str, more: &[&str]) -> Vec<Picture> {
    let out = support::scratch("btf_viewer").join(name);
    let _ = std::fs::remove_dir_all(&out);
    let folder = out.display().to_string();
    let material = material();
    let arguments = ["--headless", "--out", &folder, "--frames", "4", "--size", "96x72"];
    let arguments = [&arguments[..], &["--material", &material]].concat();
    let run = viewer(&[&arguments[..], more].concat());
    assert!(run.status.success(), "{name}: {}", words(&run));
    let pictures: Vec<_> = (0..4).map(|i| load(out.join(format!("frame_{i:03}.png")))).collect();
    for picture in &pictures {
        assert_eq!((picture.width, picture.height), (96, 72));
        assert_eq!(picture.problem(), None);
    }
    let sheet = load(out.join("contact.png"));
    assert_eq!((sheet.width, sheet.height), (4 * 96, 72));
    pictures
}

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
    assert!(config.exposure != default.exposure && config.start != default.start);
}

#[test]
fn mistakes_are_named_with_file_line_and_field() {
    let error = |text: &str| parse_ron::<Viewer>("v.ron", text).unwrap_err().to_string();
    let unknown = error("Viewer(\n    exposure: 9.0,\n    vr: true,\n)");
    assert!(unknown.starts_with("v.ron:3:") && unknown.contains("vr"), "{unknown}");
    let range = error("Viewer(\n    base_scale: 0.0,\n)");
    assert!(range.starts_with("v.ron:2: base_scale: "), "{range}");
    let name = error("Viewer(start: (object: \"cat\"))");
    assert!(name.contains("cat") && name.contains("bunny"), "{name}");
    assert!(error("Viewer(models: [])").contains("at least one"));
}

#[test]
fn a_turn_shows_the_object_from_all_sides() {
    let pictures = turntable("bunny", &["--object", "bunny", "--environment", "none"]);
    // A quarter turn moves ears, tail and legs: a picture of the plinth alone would differ by 0.
    for i in 0..4 {
        let change = difference(&pictures[i], &pictures[(i + 1) % 4]);
        assert!(change > 1.0, "{i}: {change}");
    }
}

#[test]
fn every_light_lights_and_every_object_is_there() {
    let alone = ["--environment", "none", "--object", "sphere"];
    let dark = |rig| turntable(rig, &[&alone[..], &["--light", rig]].concat())[0].mean();
    let [point, five, sun, spot] = ["point", "five", "sun", "spot"].map(dark);
    // The background alone has a mean of 27.
    for (rig, mean) in [("point", point), ("five", five), ("sun", sun), ("spot", spot)] {
        assert!(mean > 32.0, "{rig}: {mean}");
    }
    let plain = ["--light", "none", "--environment", "interior", "--progressive", "off"];
    let objects = ["plane", "drape", "hippo"];
    let shown = objects.map(|object| {
        turntable(object, &[&plain[..], &["--object", object]].concat()).swap_remove(0)
    });
    for (i, a) in shown.iter().enumerate() {
        for b in &shown[..i] {
            assert!(difference(a, b) > 2.0, "{} looks like another", objects[i]);
        }
    }
}

#[test]
fn the_light_of_environments_is_refined_or_image_based() {
    let arguments = ["--light", "none", "--environment", "evening", "--object", "bunny"];
    let [refined, image_based] = ["on", "off"].map(|progressive| {
        let more = [&arguments[..], &["--progressive", progressive]].concat();
        turntable(progressive, &more).swap_remove(0)
    });
    let change = difference(&refined, &image_based);
    let (bright, other) = (refined.mean(), image_based.mean());
    println!("{change:.1} of 255 apart; mean {bright:.1} refined, {other:.1} image-based");
    assert!(change > 0.5, "no shadows");
    assert!((bright / other - 1.0).abs() < 0.25, "{bright} {other}");
}

#[test]
fn what_cannot_be_read_is_said() {
    let out = support::scratch("btf_viewer").join("errors").display().to_string();
    let headless = ["--headless", "--out", &out, "--frames", "1", "--size", "32x32"];
    let run = |more: &[&str]| viewer(&[&headless[..], more].concat());
    let damaged = support::scratch("damaged.fbtf");
    std::fs::write(&damaged, b"no material").unwrap();
    let damaged = damaged.display().to_string();
    let material = material();
    for option in ["--material", "--environment", "--object"] {
        let fine: &[&str] = if option == "--material" { &[] } else { &["--material", &material] };
        let output = run(&[&[option, &damaged], fine].concat());
        assert_eq!(output.status.code(), Some(1), "{option}: {}", words(&output));
        assert!(words(&output).contains("damaged"), "{option}: {}", words(&output));
    }
    let output = run(&["--object", "unicorn"]);
    assert!(words(&output).contains("unicorn") && words(&output).contains("hippo"));
    assert_eq!(viewer(&["--light", "moon"]).status.code(), Some(2));
    assert_eq!(viewer(&["--progressive", "maybe"]).status.code(), Some(2));
    assert_eq!(viewer(&["--headless"]).status.code(), Some(2));
    let help = viewer(&["--help"]);
    assert!(help.status.success() && words(&help).contains("--environment NAME"));
}
