//! Actions, and the program as people see it.

use farlight_btf_codec::synthetic;

use crate::{
    material,
    support::{
        self,
        example::{difference, load, words},
    },
    viewer,
};

/// One recording for all devices: what an action does, it says, and it is seen.
#[test]
fn recorded_actions_change_what_is_shown() {
    let folder = support::scratch("btf_viewer").join("replay");
    std::fs::create_dir_all(&folder).unwrap();
    for (name, colour) in [("bright", [0.8, 0.7, 0.5]), ("red", [0.6, 0.05, 0.05])] {
        let file = folder.join(format!("{name}.fbtf"));
        synthetic::lambert(colour, [16, 16]).unwrap().write(&file).unwrap();
    }
    let config = folder.join("a.viewer.ron");
    let text = r#"Viewer(
        models: [(name: "ball", shape: Sphere), (name: "square", shape: Plane)],
        materials: [(name: "bright", path: "FOLDER/bright.fbtf"), (name: "red", path: "FOLDER/red.fbtf")],
        progressive: (lights: 40),
        controls: "",
        start: (object: "ball", material: "bright", light: None, environment: "studio"),
    )"#;
    let place = folder.display().to_string().replace('\\', "/");
    std::fs::write(&config, text.replace("FOLDER", &place)).unwrap();
    let recording = folder.join("a.recording");
    std::fs::write(
        &recording,
        "farlight-recording 1
actions next_material next_model next_environment more_lights rotate_object coarser_material evaluation_2 \
xr_screenshot toggle_floor finer_picture
2 0.032 0=1 1=1
3 0.048 0 1
4 0.064 3=1 8=1
5 0.080 3 8
6 0.096 3=1
7 0.112 3
8 0.128 4=10,0 5=1
9 0.144 5 6=1
13 0.208 4 6
14 0.224 2=1 7=1
15 0.240 2 7
16 0.256 9=1
17 0.272 9
20 0.320
",
    )
    .unwrap();
    let out = folder.display().to_string();
    let (config, recording) = (config.display().to_string(), recording.display().to_string());
    let run = viewer(&[
        "--headless",
        "--out",
        &out,
        "--size",
        "96x72",
        "--config",
        &config,
        "--replay",
        &recording,
    ]);
    let said = words(&run);
    assert!(run.status.success(), "{said}");
    for line in [
        "Material: red",
        "Object: square",
        "Lights a frame: 6",
        "Lights a frame: 7",
        "Plinth off",
        "Material at 1/2 of its resolution",
        "Evaluation: nearest texel",
        "Environment: sky",
        "No headset",
        "Resolution: 125 %",
    ] {
        assert!(said.contains(line), "{line:?} was not said:\n{said}");
    }
    // Ten degrees in each of five frames.
    for state in ["turn: 50.0", "per_frame: 7", "halvings: 1.0", "evaluation: Nearest"] {
        assert!(said.contains(state), "not {state:?}:\n{said}");
    }
    let [before, after] = ["before.png", "after.png"].map(|name| load(folder.join(name)));
    let change = difference(&before, &after);
    assert!(change > 5.0, "{change}");
    // A recording that is damaged is said with its line.
    std::fs::write(folder.join("b.recording"), "farlight-recording 1\nactions fly\n1 0.1 0=1\n")
        .unwrap();
    let damaged = folder.join("b.recording").display().to_string();
    let run = viewer(&["--headless", "--out", &out, "--replay", &damaged]);
    assert_eq!(run.status.code(), Some(1));
    assert!(words(&run).contains("fly"), "{}", words(&run));
}

#[test]
fn the_program_shows_itself() {
    let out = support::scratch("btf_viewer").join("ui");
    let folder = out.display().to_string();
    let material = material();
    let arguments = ["--headless", "--out", &folder, "--ui", "--size", "320x200", "--xr", "off"];
    let more = ["--material", &material, "--object", "sphere", "--environment", "none"];
    let run = viewer(&[&arguments[..], &more].concat());
    assert!(run.status.success(), "{}", words(&run));
    let [first, help, menu, left, right] = ["first", "help", "menu", "left", "right"]
        .map(|name| load(out.join(format!("{name}.png"))));
    assert!(difference(&first, &help) > 2.0 && difference(&first, &menu) > 2.0);
    assert!(difference(&help, &menu) > 2.0 && difference(&menu, &left) > 2.0);
    // Eyes are apart.
    assert!(difference(&left, &right) > 0.5);
    assert!(words(&run).contains("point at the panel"));
}
