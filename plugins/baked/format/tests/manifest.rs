//! Texts of manifests, and what is wrong with them.

#[path = "common/sample.rs"]
mod sample;

use farlight_baked_format::manifest::{
    LightKind, Manifest, ManifestError, Settings, VERSION, VOLUME_TEXELS,
};
use sample::manifest;

/// The error of the sample after a change.
fn error(change: impl FnOnce(&mut Manifest)) -> String {
    let mut manifest = manifest(3);
    change(&mut manifest);
    let error = manifest.validate().unwrap_err();
    // What is read is checked too.
    assert_eq!(Manifest::parse(&manifest.to_text()), Err(error.clone()));
    error.to_string()
}

#[test]
fn a_manifest_there_and_back() {
    let manifest = manifest(3);
    let text = manifest.to_text();
    println!("{text}");
    assert_eq!(Manifest::parse(&text), Ok(manifest));
    assert!(text.starts_with("BakedManifest("), "{text}");
    // A receiver, a light, a page, a volume a line.
    for once in
        ["node: 7, primitive: 1", "ktx2: \"room.lamp.0.0badc0de.ktx2\", exr:", "kind: Spot("]
    {
        let lines = text.lines().filter(|line| line.contains(once)).count();
        assert_eq!(lines, 1, "{once}\n{text}");
    }
    assert!(text.lines().all(|line| line.len() < 400), "{text}");
}

#[test]
fn large_scenes_are_fine() {
    let manifest = manifest(10_000);
    let text = manifest.to_text();
    assert!(text.lines().count() < 10_100 && text.len() < 2_000_000, "{}", text.len());
    assert_eq!(Manifest::parse(&text), Ok(manifest));
}

#[test]
fn what_may_be_left_out() {
    let text = "(
        version: 1, scene: \"a.glb\", input: \"00000000000000000000000000000000\", complete: false,
        settings: (), page_size: 0, pages: 0, receivers: [],
        scenarios: [(name: \"day\", pages: [], samples: 1, relative_error: 0)], // nothing is lit
    )";
    let manifest = Manifest::parse(text).unwrap();
    assert_eq!(manifest.settings, Settings { scale: 1.0, ..Default::default() });
    assert!(manifest.scenario("day").is_some() && manifest.scenario("night").is_none());
}

#[test]
fn errors_name_the_field() {
    let cases: [(&str, String); 29] = [
        ("scene: ", error(|m| m.scene = "../room.glb".into())),
        ("scene: ", error(|m| m.scene = "room.gltf".into())),
        ("settings.scale: 0", error(|m| m.settings.scale = 0.0)),
        ("settings.texels_per_metre: ", error(|m| m.settings.texels_per_metre = -1.0)),
        ("page_size: 8193 is not 1 to 8192", error(|m| m.page_size = 8193)),
        ("page_size: 0", error(|m| m.page_size = 0)),
        ("pages: 1025", error(|m| m.pages = 1025)),
        ("receivers[1].page: there is no page 2, only 2", error(|m| m.receivers[1].page = 2)),
        ("receivers[2].rect: ", error(|m| m.receivers[2].rect = [0, 0, 513, 1])),
        ("receivers[2].rect: ", error(|m| m.receivers[2].rect = [u32::MAX, 0, 2, 2])),
        ("receivers[2].rect: ", error(|m| m.receivers[2].rect = [0, 0, 0, 1])),
        ("receivers[2].primitive: ", error(|m| m.receivers[2] = m.receivers[0].clone())),
        (
            "left_out[0].primitive: ",
            error(|m| (m.left_out[0].node, m.left_out[0].primitive) = (5, 1)),
        ),
        ("volumes[0].transform: ", error(|m| m.volumes[0].transform[3][1] = f32::NAN)),
        ("volumes[0].transform: ", error(|m| m.volumes[0].transform[1] = [0.0; 3])),
        ("volumes[0].resolution: ", error(|m| m.volumes[0].resolution = [1, 0, 1])),
        ("volumes[0].resolution: ", error(|m| m.volumes[0].resolution = [256, 256, 256])),
        ("volumes[0].resolution: ", error(|m| m.volumes[0].resolution = [1, 1, VOLUME_TEXELS / 2])),
        ("volumes[0].resolution: ", error(|m| m.volumes[0].resolution = [u32::MAX; 3])),
        ("scenarios: there is none", error(|m| m.scenarios.clear())),
        ("scenarios[1].name: \"day\"", error(|m| m.scenarios[1].name = "day".into())),
        ("scenarios[0].name: it has none", error(|m| m.scenarios[0].name.clear())),
        ("scenarios[1].pages: it has 1 pages", error(|m| drop(m.scenarios[1].pages.pop()))),
        (
            "scenarios[1].pages[1].ktx2: ",
            error(|m| m.scenarios[1].pages[1].ktx2 = "a/b.ktx2".into()),
        ),
        ("scenarios[1].pages[1].exr: ", error(|m| m.scenarios[1].pages[1].exr = ".exr".into())),
        ("scenarios[0].volumes: it has 0 volumes", error(|m| m.scenarios[0].volumes.clear())),
        ("scenarios[0].volumes[0]: ", error(|m| m.scenarios[0].volumes[0] = "..".into())),
        ("scenarios[0].sky: inf", error(|m| m.scenarios[0].sky[2] = f32::INFINITY)),
        ("scenarios[0].relative_error: NaN", error(|m| m.scenarios[0].relative_error = f32::NAN)),
    ];
    for (expected, error) in cases {
        assert!(error.starts_with(expected), "{error} instead of {expected}");
    }
}

#[test]
fn errors_of_lights_name_the_field() {
    fn light(change: impl FnOnce(&mut farlight_baked_format::manifest::Light)) -> String {
        error(|m| change(&mut m.scenarios[1].lights[1]))
    }
    let spot = |inner, outer| LightKind::Spot { inner, outer };
    let cases = [
        ("node: another", light(|l| l.node = Some(9))),
        ("position: ", light(|l| l.position[0] = f32::NAN)),
        ("direction: ", light(|l| l.direction = [0.0, 2.0, 0.0])),
        ("direction: ", light(|l| l.direction = [f32::INFINITY; 3])),
        ("kind: ", light(|l| l.kind = spot(0.5, 0.4))),
        ("kind: ", light(|l| l.kind = spot(0.5, 1.6))),
        ("kind: ", light(|l| l.kind = spot(f32::NAN, 1.0))),
        ("intensity: -1", light(|l| l.intensity[1] = -1.0)),
        ("range: ", light(|l| l.range = f32::NAN)),
        ("radius: ", light(|l| l.radius = -0.1)),
    ];
    for (expected, error) in cases {
        let expected = format!("scenarios[1].lights[1].{expected}");
        assert!(error.starts_with(&expected), "{error} instead of {expected}");
    }
}

#[test]
fn other_texts_are_refused() {
    let found = error(|m| m.version = VERSION + 1);
    assert_eq!(found, "version 2 of the format, this is 1: bake the scene again");
    let text = manifest(1).to_text();
    let bad = text.replace("complete: true", "complet: true");
    let error = Manifest::parse(&bad).unwrap_err();
    assert!(matches!(&error, ManifestError::Syntax(text) if text.starts_with("5:")), "{error}");
    assert!(error.to_string().contains("complet"), "{error}");
    let deep = "[".repeat(100_000);
    for bad in ["", "GiSettings()", "BakedManifest(", &deep] {
        assert!(matches!(Manifest::parse(bad), Err(ManifestError::Syntax(_))));
    }
}
