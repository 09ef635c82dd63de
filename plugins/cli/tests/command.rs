//! The command as a user runs it: exit codes, messages, files.

mod support;

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use serde_json::{Value, json};
use support::{Folder, refused};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/TwoRooms.glb");

fn farlight(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_farlight")).args(arguments).output().unwrap()
}

fn bake(receivers: &Path, result: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["bake", SCENE, "--receivers"];
    arguments.extend([receivers.to_str().unwrap(), "--result", result.to_str().unwrap()]);
    arguments.extend(more);
    farlight(&arguments)
}

fn channels(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Under the light in the bright room, behind the wall in the dark room.
fn job() -> String {
    json!({
        "surface": [
            { "position": [2.0, 0.0, 1.2], "normal": [0.0, 1.0, 0.0] },
            { "position": [8.0, 0.0, 0.5], "normal": [0.0, 1.0, 0.0] },
        ],
        "probes": [[2.0, 1.0, 2.0]],
        "visibility": [{ "point": [2.0, 1.0, 1.2], "light": 0 }, { "point": [8.0, 1.0, 0.5], "light": 0 }],
    })
    .to_string()
}

#[test]
fn bake_answers_in_order_and_repeats_itself() {
    let folder = Folder::new("order");
    let receivers = folder.write("in.json", &job());
    let result = folder.at("out.json");
    let run = |more: &[&str]| {
        let output = bake(&receivers, &result, more);
        assert!(output.status.success(), "{output:?}");
        fs::read_to_string(&result).unwrap()
    };
    let first = run(&["--samples", "256", "--seed", "3"]);
    assert_eq!(first, run(&["--samples", "256", "--seed", "3"]));
    assert_ne!(first, run(&["--samples", "256", "--seed", "4"]));

    let out: Value = serde_json::from_str(&first).unwrap();
    let [bright, dark] = [&out["surface"][0], &out["surface"][1]];
    // I / r²: 30, 28.5, 25.5 W/sr at 2.2 m.
    for (found, intensity) in channels(&bright["direct"]).iter().zip([30.0, 28.5, 25.5]) {
        assert!((found - intensity / (2.2 * 2.2)).abs() < 1e-3, "{found}");
    }
    assert_eq!(channels(&dark["direct"]), [0.0; 3]);
    for entry in [bright, dark] {
        for key in ["indirect", "indirect_se", "indirect_one_bounce", "indirect_one_bounce_se"] {
            assert!(channels(&entry[key]).iter().all(|x| *x >= 0.0), "{key}: {entry}");
        }
        assert!(channels(&entry["indirect"])[0] > 0.0);
    }
    let probe = &out["probes"][0];
    for key in ["sh", "sh_se"] {
        let rows = probe[key].as_array().unwrap();
        assert_eq!(rows.len(), 9);
        assert!(rows.iter().all(|r| channels(r).len() == 3));
    }
    assert_eq!(out["visibility"], json!([1, 0]));
    // Nothing else is left behind.
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

/// A constant sky outside of closed rooms changes nothing; at a point on the roof it is direct.
#[test]
fn the_sky_is_direct_where_it_is_seen() {
    let folder = Folder::new("sky");
    let roof = json!({ "surface": [{ "position": [2.0, 50.0, 2.0], "normal": [0.0, 1.0, 0.0] }] });
    let receivers = folder.write("in.json", &roof.to_string());
    let result = folder.at("out.json");
    let output = bake(&receivers, &result, &["--samples", "64", "--sky", "1,2,0.5"]);
    assert!(output.status.success(), "{output:?}");
    let out: Value = serde_json::from_str(&fs::read_to_string(&result).unwrap()).unwrap();
    for (found, sky) in channels(&out["surface"][0]["direct"]).iter().zip([1.0, 2.0, 0.5]) {
        assert!((found - std::f64::consts::PI * sky).abs() < 1e-4, "{found}");
    }
    assert_eq!(channels(&out["surface"][0]["indirect"]), [0.0; 3]);
}

/// With the range window a light of 20 m range is weaker by (1 - (d/20)⁴)²; lengths are scaled.
#[test]
fn range_window_and_scale() {
    let folder = Folder::new("range");
    let place = json!({ "surface": [{ "position": [8.0, 0.0, 4.8], "normal": [0.0, 1.0, 0.0] }] });
    let receivers = folder.write("in.json", &place.to_string());
    let result = folder.at("out.json");
    let direct = |more: &[&str]| {
        let mut arguments = vec!["--samples", "1", "--scale", "4"];
        arguments.extend(more);
        let output = bake(&receivers, &result, &arguments);
        assert!(output.status.success(), "{output:?}");
        let out: Value = serde_json::from_str(&fs::read_to_string(&result).unwrap()).unwrap();
        channels(&out["surface"][0]["direct"])[0]
    };
    let d = 4.0 * 2.2_f64;
    let plain = 30.0 / (d * d);
    assert!((direct(&[]) - plain).abs() < 1e-4);
    // The range is the file's, or 20 m where it has none, and follows the scale.
    let window = |range: f64| plain * (1.0 - (d / range).powi(4)).powi(2);
    let found = direct(&["--range-window"]);
    assert!(
        [20.0, 80.0].iter().any(|r| (found - window(*r)).abs() < 1e-4) && found < plain,
        "{found} {plain}"
    );
}

#[test]
fn errors_help() {
    let folder = Folder::new("errors");
    let good = folder.write("in.json", &job());
    let result = folder.at("out.json");

    let missing = refused(&bake(&folder.at("none.json"), &result, &[]));
    assert!(missing.contains("none.json"), "{missing}");
    let syntax = folder.write("syntax.json", "{\n  \"surface\": [\n");
    let message = refused(&bake(&syntax, &result, &[]));
    assert!(message.contains("syntax.json:"), "{message}");
    let light = folder.write("light.json", r#"{"visibility": [{"point": [0, 0, 0], "light": 1}]}"#);
    let message = refused(&bake(&light, &result, &[]));
    assert!(message.contains("light.json") && message.contains("visibility[0].light"), "{message}");
    let message = refused(&bake(&good, &folder.at("no/such/out.json"), &["--samples", "1"]));
    assert!(message.contains("out.json"), "{message}");
    for bad in [["--sky", "1,2"], ["--scale", "0"], ["--samples", "0"], ["--seed", "x"]] {
        let message = refused(&bake(&good, &result, &bad));
        assert!(message.contains(bad[0]), "{message}");
    }
    let not_gltf = folder.write("scene.glb", "not a scene");
    let [good, out] = [good.to_str().unwrap(), result.to_str().unwrap()];
    let scene = not_gltf.to_str().unwrap();
    let message = refused(&farlight(&["bake", scene, "--receivers", good, "--result", out]));
    assert!(message.contains("scene.glb"), "{message}");
    // No error leaves a result, or part of one.
    assert!(!result.exists());
    let parts = fs::read_dir(folder.path())
        .unwrap()
        .filter(|e| e.as_ref().unwrap().file_name().to_string_lossy().contains(".part"));
    assert_eq!(parts.count(), 0);
}

/// A result that exists is replaced only by a whole one.
#[test]
fn a_failed_run_keeps_the_old_result() {
    let folder = Folder::new("keep");
    let bad = folder.write("in.json", r#"{"surface": [{"position": [0, 0, 0]}]}"#);
    let result = folder.write("out.json", "old");
    refused(&bake(&bad, &result, &[]));
    assert_eq!(fs::read_to_string(&result).unwrap(), "old");
}

#[test]
fn check_tells_good_from_bad() {
    let folder = Folder::new("check");
    let good = folder.write("good.ron", "GiSettings(bounces: 3)");
    let bad = folder.write("bad.ron", "GiSettings(\n    bounces: 3,\n    page_size: 100,\n)");
    let output = farlight(&["check", good.to_str().unwrap()]);
    assert!(output.status.success(), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("GiSettings"));
    let message = refused(&farlight(&["check", bad.to_str().unwrap()]));
    assert!(message.contains("bad.ron:3") && message.contains("page_size"), "{message}");
}

#[test]
fn help_explains_the_files() {
    let output = farlight(&["bake", "--help"]);
    let text = String::from_utf8_lossy(&output.stdout);
    for word in
        ["--receivers", "--range-window", "indirect_one_bounce", "IN.json", "standard error"]
    {
        assert!(text.contains(word), "{word}");
    }
}
