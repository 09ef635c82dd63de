//! Bindings in files: written, read, refused.

use farlight_bindings::{
    ACTIONS, ActionBindings, Binding, Bindings, Device, Preset, Profile, Sensitivity, defaults_ron,
};

fn binding(text: &str) -> Binding {
    text.parse().unwrap()
}

/// Everything that can stand in a file.
fn full() -> Bindings {
    let treated = Binding {
        dead_zone: 0.25,
        curve: 1.5,
        scale: -1e-5,
        invert_x: true,
        invert_y: true,
        ..binding("Left.Trigger+Left.Stick")
    };
    let mut bindings = Bindings {
        preset: Preset::Room,
        invert_zoom: true,
        invert_look: true,
        sensitivity: Sensitivity(1.75),
        unused: vec!["pan".into(), "a \"game's\" other\n".into()],
        ..Bindings::default()
    };
    bindings.bindings.insert(
        "orbit".into(),
        ActionBindings {
            keyboard_mouse: Some(vec![binding("Ctrl+LeftDrag"), binding("KeyA|KeyD|KeyS|KeyW")]),
            gamepad: Some(vec![]),
            xr: Some(vec![treated.clone(), binding("Right.Trackpad")]),
            xr_vive: Some(vec![Binding { scale: 90.0, ..binding("Left.Trackpad") }]),
            ..ActionBindings::default()
        },
    );
    bindings.bindings.insert(
        "a \"game's\" own\n".into(),
        ActionBindings { gamepad: Some(vec![treated; 16]), ..ActionBindings::default() },
    );
    bindings
}

#[test]
fn a_binding_is_a_text_or_has_fields() {
    for text in ["\"KeyM\"", "\"Shift+KeyM\"", "(input: \"LeftStick\", scale: 90)"] {
        let binding: Binding = ron::from_str(text).unwrap();
        let again = ron::to_string(&binding).unwrap();
        assert_eq!(ron::from_str::<Binding>(&again).unwrap(), binding, "{again}");
    }
    assert_eq!(ron::to_string(&binding("Shift+KeyM")).unwrap(), "\"Shift+KeyM\"");
    let stick: Binding =
        ron::from_str("(input: \"LeftStick\", curve: 2.0, invert_y: true)").unwrap();
    let expected = Binding { curve: 2.0, invert_y: true, ..binding("LeftStick") };
    assert_eq!(stick, expected);
    assert_eq!((stick.dead_zone, stick.scale), (0.15, 1.0));
    // The name of the type may stand before it.
    let named: Binding = ron::from_str("Binding(input: \"KeyM\")").unwrap();
    assert_eq!(named, binding("KeyM"));
}

#[test]
fn what_is_written_is_read() {
    let bindings = full();
    let text = bindings.to_ron();
    assert_eq!(
        Bindings::from_ron(&text).unwrap_or_else(|e| panic!("{e}\n{text}")),
        bindings,
        "{text}"
    );
    // Serde's own way, with which programs keep settings.
    let plain = ron::to_string(&bindings).unwrap();
    assert_eq!(Bindings::from_ron(&plain), Ok(bindings), "{plain}");
    let pretty = ron::ser::to_string_pretty(&full(), ron::ser::PrettyConfig::new()).unwrap();
    assert_eq!(Bindings::from_ron(&pretty), Ok(full()), "{pretty}");
}

#[test]
fn the_file_is_one_that_people_read() {
    let mut bindings = Bindings { invert_zoom: true, ..Bindings::default() };
    bindings.set("menu", Device::KeyboardMouse, vec![binding("Tab")]);
    bindings.set("menu", Device::Xr(Profile::Vive), vec![binding("Right.Menu")]);
    // As it is anyway: left out.
    bindings.set("help", Device::KeyboardMouse, vec![binding("F1")]);
    let text = bindings.to_ron();
    let body: Vec<_> = text.lines().filter(|line| !line.starts_with("//")).collect();
    assert_eq!(
        body,
        [
            "ControlsSettings(",
            "    invert_zoom: true,",
            "    bindings: {",
            "        \"menu\": (keyboard_mouse: [\"Tab\"], xr_vive: [\"Right.Menu\"]),",
            "    },",
            ")",
        ]
    );
    assert!(text.starts_with("// ") && text.contains("farlight check"));
    assert!(Bindings::default().to_ron().ends_with("ControlsSettings(\n)\n"));
}

#[test]
fn one_binding_needs_no_brackets() {
    let text =
        "ControlsSettings(bindings: {\"menu\": (gamepad: \"Start\", touch: (input: \"Tap\"))})";
    let menu = &Bindings::from_ron(text).unwrap().bindings["menu"];
    assert_eq!(menu.gamepad, Some(vec![binding("Start")]));
    assert_eq!(menu.touch, Some(vec![binding("Tap")]));
}

#[test]
fn a_list_for_all_headsets_counts_where_there_is_none_of_its_own() {
    let text = "ControlsSettings(bindings: {\"menu\": (
        xr: [\"Left.Secondary\", \"Left.Menu\"], xr_vive: [\"Right.Menu\"], xr_hands: [],
    )})";
    let mut bindings = Bindings::from_ron(text).unwrap();
    let menu = |bindings: &Bindings, profile| -> Vec<String> {
        let list = bindings.of("menu", Device::Xr(profile));
        list.iter().map(Binding::input_text).collect()
    };
    assert_eq!(menu(&bindings, Profile::Touch), ["Left.Secondary", "Left.Menu"]);
    // What a controller doesn't have is left out.
    assert_eq!(menu(&bindings, Profile::Index), ["Left.Secondary"]);
    assert_eq!(menu(&bindings, Profile::Simple), ["Left.Menu"]);
    assert_eq!(menu(&bindings, Profile::Vive), ["Right.Menu"]);
    assert_eq!(menu(&bindings, Profile::Hands), [""; 0]);
    let again = Bindings::from_ron(&bindings.to_ron()).unwrap();
    assert_eq!(again, bindings);
    // The defaults, though something is set for all headsets.
    for device in Device::ALL {
        bindings.restore("menu", device);
        assert_eq!(bindings.of("menu", device), Bindings::default().of("menu", device), "{device}");
    }
    let again = Bindings::from_ron(&bindings.to_ron()).unwrap();
    for device in Device::ALL {
        assert_eq!(again.of("menu", device), Bindings::default().of("menu", device), "{device}");
    }
}

#[test]
fn an_unused_action_has_the_inputs_of_the_file_and_no_others() {
    let text = "ControlsSettings(
        unused: [\"pan\", \"menu\", \"jump\"],
        bindings: {\"menu\": (keyboard_mouse: [\"Tab\"], xr: [\"Left.Menu\"])},
    )";
    let mut bindings = Bindings::from_ron(text).unwrap();
    assert!(bindings.is_unused("pan") && !bindings.is_unused("orbit"));
    for device in Device::ALL {
        assert_eq!(bindings.of("pan", device), [], "{device}");
        assert_eq!(bindings.of("orbit", device), Bindings::default().of("orbit", device));
    }
    assert_eq!(bindings.of("menu", Device::KeyboardMouse), [binding("Tab")]);
    assert_eq!(bindings.of("menu", Device::Gamepad), []);
    assert_eq!(bindings.of("menu", Device::Xr(Profile::Vive)), [binding("Left.Menu")]);
    assert_eq!(Bindings::from_ron(&bindings.to_ron()), Ok(bindings.clone()));
    // What is as it is anyway is left out: here, nothing.
    bindings.set("pan", Device::Gamepad, vec![]);
    assert!(!bindings.without_defaults().bindings.contains_key("pan"));
    for device in Device::ALL {
        bindings.restore("menu", device);
        assert_eq!(bindings.of("menu", device), [], "{device}");
    }
    // Who finds it after all, has it.
    bindings.set("pan", Device::Gamepad, vec![binding("RightStick")]);
    assert_eq!(bindings.of("pan", Device::Gamepad), [binding("RightStick")]);
    assert_eq!(bindings.of("pan", Device::KeyboardMouse), []);
}

#[test]
fn many_unused_actions_stand_on_lines_that_people_read() {
    let unused = ACTIONS.iter().map(|info| info.name.to_owned()).collect();
    let bindings = Bindings { unused, ..Bindings::default() };
    let text = bindings.to_ron();
    assert!(text.lines().all(|line| line.chars().count() <= 101), "{text}");
    assert!(text.lines().count() < 20, "{text}");
    assert_eq!(Bindings::from_ron(&text), Ok(bindings));
}

#[test]
fn the_file_of_defaults_changes_nothing() {
    for preset in Preset::ALL {
        let text = defaults_ron(preset);
        let read = Bindings::from_ron(&text).unwrap();
        assert_eq!(read.check(&[]), []);
        let defaults = Bindings { preset, ..Bindings::default() };
        assert_eq!(read.without_defaults(), defaults);
        for info in ACTIONS {
            assert!(text.contains(&format!("\"{}\":", info.name)), "{info}");
            for device in Device::ALL {
                assert_eq!(read.of(info.name, device), defaults.of(info.name, device), "{info}");
            }
        }
        assert!(text.lines().all(|line| line.chars().count() <= 120));
    }
}

#[test]
fn errors_name_line_column_and_field() {
    for (text, error) in [
        (
            "ControlsSettings(\n  invert_zom: true,\n)",
            "2:3: invert_zom: there is no field \"invert_zom\"; did you mean invert_zoom?",
        ),
        (
            "ControlsSettings(\n  preset: Rom,\n)",
            "2:11: preset: there is no value \"Rom\"; did you mean Room?",
        ),
        (
            "ControlsSettings(\n  preset: Flat,\n)",
            "2:11: preset: there is no value \"Flat\"; there are Viewer, Room",
        ),
        ("ControlsSettings(\n  invert_look: 1,\n)", "2:16: invert_look: Expected boolean"),
        (
            "ControlsSettings(bindings: {\n  \"menu\": (gamepad: [\"South\", \"Nroth\"]),\n})",
            "2:31: bindings.menu.gamepad[1]: \"Nroth\" is no input; did you mean North?",
        ),
        (
            "ControlsSettings(bindings: {\n  \"menu\": (gamepadd: []),\n})",
            "2:12: bindings.menu.gamepadd: there is no field \"gamepadd\"; did you mean gamepad?",
        ),
        (
            "ControlsSettings(bindings: {\n  \"zoom\": (gamepad: [(input: \"LeftStick\", scal: 1.0)]),\n})",
            "2:43: bindings.zoom.gamepad[0].scal: there is no field \"scal\"; did you mean scale?",
        ),
        (
            "ControlsSettings(bindings: {\n  \"zoom\": (gamepad: [(input: \"LeftStick\", scale: \"x\")]),\n})",
            "2:50: bindings.zoom.gamepad[0].scale: Expected float",
        ),
        (
            "ControlsSettings(bindings: {\n  \"menu\": (gamepad: [\"A+B+C+D+South\"]),\n})",
            "2:22: bindings.menu.gamepad[0]: \"A+B+C+D+South\": more than three inputs to hold",
        ),
        (
            "ControlsSettings(bindings: {\n  \"zoom\": (gamepad: [(input: \"LeftStik\", scale: 1.0)]),\n})",
            "2:30: bindings.zoom.gamepad[0].input: \"LeftStik\" is no input; did you mean LeftStick?",
        ),
        (
            "ControlsSettings(bindings: {\n \"menu\": (),\n \"menu\": (),\n})",
            "3:2: bindings.menu: \"menu\" is there twice",
        ),
        ("ControlsSettings(\n  unused: \"menu\",\n)", "2:11: unused: Expected opening `[`"),
    ] {
        let found = Bindings::from_ron(text).unwrap_err();
        assert_eq!(found.to_string(), error);
    }
}

#[test]
fn files_have_bounds() {
    let list = ["\"KeyM\""; 17].join(",");
    let many = format!("ControlsSettings(bindings: {{\"menu\": (gamepad: [{list}])}})");
    assert!(Bindings::from_ron(&many).unwrap_err().message.contains("more than 16"));
    let actions: String = (0..600).map(|n| format!("\"a{n}\": (),")).collect();
    let many = format!("ControlsSettings(bindings: {{{actions}}})");
    assert!(Bindings::from_ron(&many).unwrap_err().message.contains("more than 512"));
    let names: String = (0..600).map(|n| format!("\"a{n}\",")).collect();
    let many = format!("ControlsSettings(unused: [{names}])");
    assert!(Bindings::from_ron(&many).unwrap_err().message.contains("more than 512"));
    let long = format!("ControlsSettings({})", " ".repeat(1 << 20));
    assert!(Bindings::from_ron(&long).unwrap_err().message.contains("longer"));
    let deep = format!("ControlsSettings(bindings: {}", "[(".repeat(100_000));
    assert!(Bindings::from_ron(&deep).is_err());
}
