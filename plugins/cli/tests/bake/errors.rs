//! Messages that help, and files that are not ours.

use std::fs;

use crate::{
    folder::{SCENE, bake, baked, checked, command, contents},
    support::{Folder, refused, succeeded},
};

const QUICK: [&str; 5] = ["--size", "64", "--samples", "2", "--no-probes"];

#[test]
fn options_that_exclude_each_other() {
    let folder = Folder::new("bake-options");
    let out = folder.at("out");
    for (more, expected) in [
        (&["--receivers", "a.json", "--result", "b.json"][..], "--receivers"),
        (&["--size", "64", "--resolution", "8"], "--resolution"),
        (&["--samples", "2", "--quality", "draft"], "--quality"),
        (&["--time", "2", "--quality", "draft"], "--time"),
        (&["--no-probes", "--probe-spacing", "2"], "--no-probes"),
        (&["--range-window"], "--range-window"),
        (&["--scenario", "noon"], "--lights"),
        (&["--size", "100"], "power of two"),
        (&["--resolution", "0"], "texels a metre"),
        (&["--sky", "1,2"], "--sky"),
        (&["--emissive-exposure", "bright"], "nits"),
        (&["--probe-spacing", "0"], "0.01 m"),
    ] {
        let message = refused(&bake(&out, more));
        assert!(message.contains(expected), "{more:?}: {message}");
    }
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_farlight"))
        .args(["bake", SCENE, "--receivers", "a.json", "--result", "b.json", "--no-probes"])
        .output()
        .unwrap();
    assert!(refused(&output).contains("--no-probes"));
    assert!(!out.exists(), "nothing is made before the options are good");
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_farlight"))
        .args(["bake", SCENE])
        .output()
        .unwrap();
    let message = refused(&output);
    assert!(message.contains("--out") && message.contains("--receivers"), "{message}");
}

#[test]
fn inputs_that_can_not_be_baked() {
    let folder = Folder::new("bake-inputs");
    let out = folder.at("out");
    let refuse = |scene: &str, more: &[&str]| {
        refused(&command(scene, &out, &[&QUICK[..], more].concat()).output().unwrap())
    };
    let message = refuse("no.glb", &[]);
    assert!(message.contains("no.glb"), "{message}");
    let empty = folder.write("empty.gltf", r#"{"asset": {"version": "2.0"}}"#);
    let message = refuse(empty.to_str().unwrap(), &[]);
    assert!(message.contains("empty.gltf: nothing to light: "), "{message}");

    let lights = |text: &str| folder.write("l.ron", text).to_str().unwrap().to_owned();
    for (text, expected) in [
        (
            "BakeLights(add: [(name: \"a\", intensity: (NaN, 0, 0))])",
            "l.ron:1:30: add[0].intensity: ",
        ),
        ("BakeLights(\n  lamps: [],\n)", "l.ron:2:"),
        ("BakeLights(realtime: [\"Torch\"])", "there are \"point0\""),
        (
            "BakeLights(add: [(name: \"point0\")])",
            "l.ron:1:19: add[0].name: the scene has a light \"point0\" already",
        ),
        (
            "BakeLights(scenarios: [(name: \"a\", lights: [\"sun\"])])",
            "l.ron:1:36: scenarios[0].lights: there is no such light \"sun\"",
        ),
        (
            "BakeLights(scenarios: [(name: \"a\", emission: {\"shade\": 0})])",
            "l.ron:1:36: scenarios[0].emission: the scene has no material \"shade\"",
        ),
        ("BakeLights(scenarios: [(name: \"a\", sky: Image(file: \"noon.hdr\"))])", "noon.hdr"),
    ] {
        let message = refuse(SCENE, &["--lights", &lights(text)]);
        assert!(message.contains(expected), "{text}: {message}");
    }
    let message = refuse(SCENE, &["--lights", "none.ron"]);
    assert!(message.contains("none.ron"), "{message}");
    let good = lights("BakeLights(scenarios: [(name: \"noon\")])");
    let message = refuse(SCENE, &["--lights", &good, "--scenario", "night"]);
    assert!(message.contains("\"noon\""), "{message}");
    assert!(contents(&out).is_empty());
    // The command that only checks knows them, too.
    let check = |path: &str| {
        std::process::Command::new(env!("CARGO_BIN_EXE_farlight"))
            .args(["check", path])
            .output()
            .unwrap()
    };
    assert!(succeeded(&check(&good)).contains("BakeLights"));
    let bad = lights("BakeLights(scenarios: [()])");
    assert!(refused(&check(&bad)).contains("scenarios[0].name"));
}

#[test]
fn what_is_not_ours_stays() {
    let folder = Folder::new("bake-foreign");
    // The scene itself.
    let scene = folder.at("TwoRooms.glb");
    fs::copy(SCENE, &scene).unwrap();
    let here = command(scene.to_str().unwrap(), folder.path(), &QUICK).output().unwrap();
    let message = refused(&here);
    assert!(message.contains("choose another folder"), "{message}");
    assert!(fs::read(&scene).unwrap() == fs::read(SCENE).unwrap());
    // Another file of that name.
    let out = folder.at("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("TwoRooms.glb"), "mine").unwrap();
    let message = refused(&bake(&out, &QUICK));
    assert!(message.contains("was not made by a bake"), "{message}");
    fs::remove_file(out.join("TwoRooms.glb")).unwrap();
    // Files that only look like ours.
    let others =
        ["notes.txt", "Other.baked.ron", "TwoRooms.default.0.0123abcd.ktx2", "TwoRooms.old.exr"];
    for name in others {
        fs::write(out.join(name), "mine").unwrap();
    }
    baked(&out, &QUICK);
    baked(&out, &[&QUICK[..], &["--seed", "2"]].concat());
    checked(&out).unwrap();
    for name in others {
        assert_eq!(fs::read(out.join(name)).unwrap(), b"mine", "{name}");
    }
    assert_eq!(contents(&out).len(), 4 + others.len());
    // A folder that can't be one.
    let file = folder.write("file", "");
    let message = refused(&bake(&file.join("out"), &QUICK));
    assert!(message.contains("file"), "{message}");
}

#[test]
fn help_has_an_example_and_the_files() {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_farlight"))
        .args(["bake", "--help"])
        .output()
        .unwrap();
    let text = succeeded(&output);
    for word in ["Example:", "BakeLights(", "--quality", "IN.json", "nits", "--watch"] {
        assert!(text.contains(word), "{word}");
    }
    assert!(!text.contains("--save-every"));
}
