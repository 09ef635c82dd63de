//! What is wrong with bindings is said, and what is right is left alone.

use farlight_bindings::{
    ActionInfo, ActionKind, Binding, Bindings, Conflict, Context, Device, Preset, Profile, Severity,
};

fn own(name: &'static str, kind: ActionKind, context: Context) -> ActionInfo {
    ActionInfo { name, label: "Own", kind, context, unit: "" }
}

fn bindings(list: &str) -> Bindings {
    let text = format!("ControlsSettings(bindings: {{{list}}})");
    Bindings::from_ron(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn problems(list: &str) -> Vec<String> {
    let problems = bindings(list).check(&[]);
    problems.iter().map(|p| format!("{:?} {p}", p.severity)).collect()
}

fn binding(text: &str) -> Binding {
    text.parse().unwrap()
}

#[test]
fn defaults_have_neither_problems_nor_conflicts() {
    for preset in Preset::ALL {
        let bindings = Bindings { preset, ..Bindings::default() };
        assert_eq!(bindings.check(&[]), []);
        for device in Device::ALL {
            assert_eq!(bindings.conflicts(device, &[]), [], "{preset:?}");
        }
    }
}

#[test]
fn problems_name_the_field_and_say_what_would_be_right() {
    for (list, problem) in [
        ("\"mneu\": ()", "Error bindings.mneu: there is no such action; did you mean menu?"),
        ("\"jump\": ()", "Note bindings.jump: no action of the suite; good if the game adds it"),
        (
            "\"menu\": (gamepad: [\"KeyM\"])",
            "Error bindings.menu.gamepad[0]: KeyM is no input of this",
        ),
        ("\"menu\": (xr: [\"Start\"])", "Error bindings.menu.xr[0]: Start is no input of this"),
        (
            "\"menu\": (xr_vive: [\"Left.Menu\", \"Left.Primary\"])",
            "Error bindings.menu.xr_vive[1]: Left.Primary is no input of this device (Vive wands)",
        ),
        (
            "\"menu\": (gamepad: [\"LeftStick\"])",
            "Error bindings.menu.gamepad[0]: \"LeftStick\" does not fit: the action wants one button",
        ),
        (
            "\"orbit\": (keyboard_mouse: [\"KeyA|KeyD\"])",
            "Error bindings.orbit.keyboard_mouse[0]: \"KeyA|KeyD\" does not fit",
        ),
        (
            "\"zoom\": (keyboard_mouse: [\"KeyA|KeyD|KeyS|KeyW\"])",
            "Error bindings.zoom.keyboard_mouse[0]: \"KeyA|KeyD|KeyS|KeyW\" does not fit",
        ),
        (
            "\"orbit\": (gamepad: [(input: \"LeftStick\", dead_zone: 1.0)])",
            "Error bindings.orbit.gamepad[0].dead_zone: is 1, must be 0 to 0.95",
        ),
        (
            "\"orbit\": (gamepad: [(input: \"LeftStick\", curve: 0)])",
            "Error bindings.orbit.gamepad[0].curve: is 0, must be 0.1 to 10",
        ),
        (
            "\"orbit\": (gamepad: [(input: \"LeftStick\", scale: NaN)])",
            "Error bindings.orbit.gamepad[0].scale: is NaN, must be -100000 to 100000",
        ),
        (
            "\"orbit\": (gamepad: [(input: \"LeftStick\", scale: 0)])",
            "Error bindings.orbit.gamepad[0].scale: is 0",
        ),
        (
            "\"orbit\": (keyboard_mouse: [(input: \"LeftDrag\", curve: 2)])",
            "Warning bindings.orbit.keyboard_mouse[0]: dead_zone and curve are for sticks",
        ),
        (
            "\"menu\": (keyboard_mouse: [\"KeyM\", \"KeyM\"])",
            "Warning bindings.menu.keyboard_mouse[1]: is there already",
        ),
        (
            "\"menu\": (gamepad: [\"South+South\"])",
            "Error bindings.menu.gamepad[0]: \"South+South\" has an input twice",
        ),
    ] {
        let found = problems(list);
        assert!(found.len() == 1 && found[0].starts_with(problem), "{list}: {found:?}");
    }
    let good = "\"menu\": (keyboard_mouse: [\"Ctrl+KeyM\"], gamepad: [(input: \"LeftTrigger\", dead_zone: 0.8)])";
    assert_eq!(problems(good), [""; 0]);
    let many = (0..50).map(|n| format!("\"own{n}x\": (gamepad: [\"KeyA\", \"KeyA\", \"KeyA\"]),"));
    assert_eq!(problems(&many.collect::<String>()).len(), 100);
}

#[test]
fn unused_actions_are_actions() {
    let text = "ControlsSettings(unused: [\"pan\",\n  \"rize\", \"jump\"])";
    let mut bindings = Bindings::from_ron(text).unwrap();
    let problems = bindings.check(&[]);
    let said: Vec<_> = problems.iter().map(|p| format!("{:?} {p}", p.severity)).collect();
    assert_eq!(
        said,
        [
            "Error unused[1]: \"rize\": there is no such action; did you mean rise?",
            "Note unused[2]: \"jump\": no action of the suite; good if the game adds it under this name",
        ]
    );
    assert_eq!(
        problems.iter().filter_map(|p| p.place(text)).collect::<Vec<_>>(),
        [(2, 3), (2, 11)]
    );
    bindings.unused = vec!["pan".into(), "jump".into(), "pan".into()];
    let jump = own("jump", ActionKind::Button, Context::Scene);
    let said: Vec<_> = bindings.check(&[jump]).iter().map(ToString::to_string).collect();
    assert_eq!(said, ["unused[2]: is there already"]);
    // What nobody does is in nobody's way.
    let rise = "\"reset\": (keyboard_mouse: [\"Space\"])";
    let mut bindings = self::bindings(rise);
    assert_eq!(bindings.conflicts(Device::KeyboardMouse, &[]).len(), 1);
    bindings.unused = vec!["rise".into()];
    assert_eq!(bindings.conflicts(Device::KeyboardMouse, &[]), []);
}

#[test]
fn sensitivity_has_a_range() {
    for (value, good) in
        [("0.05", true), ("20", true), ("0.04", false), ("21", false), ("NaN", false)]
    {
        let text = format!("ControlsSettings(\n    sensitivity: {value},\n)");
        let problems = Bindings::from_ron(&text).unwrap().check(&[]);
        assert_eq!(problems.is_empty(), good, "{value}");
        for problem in problems {
            assert_eq!(problem.place(&text), Some((2, 5)));
            assert_eq!(problem.severity, Severity::Error);
        }
    }
}

#[test]
fn a_games_own_actions_are_known() {
    let jump = own("jump", ActionKind::Button, Context::Scene);
    let list = "\"jump\": (gamepad: [\"LeftStick\"]), \"jum\": ()";
    let found: Vec<_> = bindings(list).check(&[jump]).iter().map(ToString::to_string).collect();
    assert_eq!(found[0], "bindings.jum: there is no such action; did you mean jump?");
    assert!(
        found[1].starts_with("bindings.jump.gamepad[0]: \"LeftStick\" does not fit"),
        "{found:?}"
    );
}

fn conflicts(list: &str, device: Device, added: &[ActionInfo]) -> Vec<String> {
    bindings(list).conflicts(device, added).iter().map(Conflict::to_string).collect()
}

#[test]
fn conflicts_are_named() {
    let keys = Device::KeyboardMouse;
    for (list, device, conflict) in [
        // Global against Scene.
        (
            "\"reset\": (keyboard_mouse: [\"KeyM\"])",
            keys,
            "Keyboard and mouse: KeyM does reset and menu at once",
        ),
        // Parts of what moves.
        (
            "\"next_model\": (gamepad: [\"LeftStickUp\"])",
            Device::Gamepad,
            "Gamepad: LeftStick does orbit and next_model at once",
        ),
        (
            "\"reset\": (keyboard_mouse: [\"MouseLeft\"])",
            keys,
            "Keyboard and mouse: LeftDrag does orbit and reset at once",
        ),
        // The same with the same held, in another order.
        (
            "\"reset\": (gamepad: [\"LeftShoulder+RightShoulder+Start\"]), \
             \"recentre\": (gamepad: [\"RightShoulder+LeftShoulder+Start\"])",
            Device::Gamepad,
            "Gamepad: RightShoulder+LeftShoulder+Start does recentre and reset at once",
        ),
        // What is held does something already.
        (
            "\"pan\": (keyboard_mouse: [\"Shift+LeftDrag\"])",
            keys,
            "Keyboard and mouse: Shift+LeftDrag does pan and rise at once",
        ),
        (
            "\"menu\": (xr_index: [\"Left.Squeeze+Left.Secondary\"])",
            Device::Xr(Profile::Index),
            "Index controllers: Left.Squeeze+Left.Secondary does menu and grab_left at once",
        ),
        // In a panel.
        (
            "\"panel_back\": (gamepad: [\"South\"])",
            Device::Gamepad,
            "Gamepad: South does panel_press and panel_back at once",
        ),
    ] {
        assert_eq!(conflicts(list, device, &[]), [conflict], "{list}");
    }
    let three =
        "\"reset\": (keyboard_mouse: [\"KeyM\"]), \"recentre\": (keyboard_mouse: [\"KeyM\"])";
    assert_eq!(
        conflicts(three, keys, &[]),
        ["Keyboard and mouse: KeyM does recentre, reset and menu at once"]
    );
    let jump = [own("jump", ActionKind::Button, Context::Scene)];
    let list = "\"jump\": (keyboard_mouse: [\"Space\"])";
    assert_eq!(
        conflicts(list, keys, &jump),
        ["Keyboard and mouse: ShiftLeft|Space does rise and jump at once"]
    );
    assert_eq!(conflicts(list, keys, &[]), [""; 0], "nobody hears it");
}

#[test]
fn what_is_silent_is_no_conflict() {
    for (list, device) in [
        // Masked by what must be held.
        ("\"reset\": (keyboard_mouse: [\"Ctrl+KeyM\"])", Device::KeyboardMouse),
        ("\"pan\": (keyboard_mouse: [\"Alt+LeftDrag\"])", Device::KeyboardMouse),
        // Somebody would have to hold both.
        (
            "\"reset\": (keyboard_mouse: [\"Ctrl+KeyM\"]), \"recentre\": (keyboard_mouse: [\"Alt+KeyM\"])",
            Device::KeyboardMouse,
        ),
        // The panel takes it away from the scene and from what is always heard.
        ("\"panel_more\": (keyboard_mouse: [\"KeyM\"])", Device::KeyboardMouse),
        // Other directions of the same stick.
        (
            "\"orbit\": (gamepad: []), \"next_model\": (gamepad: [\"LeftStickUp\"]), \
             \"previous_model\": (gamepad: [\"LeftStickDown\"])",
            Device::Gamepad,
        ),
        // One action may have an input twice.
        (
            "\"orbit\": (keyboard_mouse: [\"LeftDrag\", \"Ctrl+RightDrag\", \"LeftDrag\"])",
            Device::KeyboardMouse,
        ),
    ] {
        assert_eq!(conflicts(list, device, &[]), [""; 0], "{list}");
    }
}

#[test]
fn rivals_are_known_before_something_is_bound() {
    let bindings = Bindings::default();
    let rivals = |action, text| bindings.rivals(action, Device::KeyboardMouse, &binding(text), &[]);
    assert_eq!(rivals("reset", "KeyM"), ["menu"]);
    assert_eq!(rivals("menu", "KeyM"), [""; 0]);
    assert_eq!(rivals("pan", "Shift+LeftDrag"), ["rise"]);
    assert_eq!(rivals("pan", "Ctrl+RightDrag"), [""; 0]);
    assert_eq!(rivals("pan", "RightDrag"), ["rotate_environment"]);
    // Ctrl is asked for by another one.
    assert_eq!(rivals("reset", "ControlLeft"), ["pan"]);
}

#[test]
fn who_asks_for_more_masks() {
    let masked = |less: &str, more: &str| binding(less).is_masked_by(&binding(more));
    assert!(masked("LeftDrag", "Ctrl+LeftDrag"));
    assert!(masked("KeyA|KeyD|KeyS|KeyW", "Ctrl+KeyA"));
    assert!(masked("LeftStick", "LeftShoulder+LeftStickUp"));
    assert!(masked("Ctrl+KeyM", "Alt+Ctrl+KeyM"));
    assert!(masked("Shift+KeyM", "ShiftLeft+Ctrl+KeyM"));
    assert!(masked("Shift+KeyM", "ShiftLeft+KeyM"));
    assert!(!masked("Ctrl+LeftDrag", "LeftDrag"));
    assert!(!masked("LeftDrag", "LeftDrag"));
    assert!(!masked("Alt+LeftDrag", "Ctrl+LeftDrag"));
    assert!(!masked("RightDrag", "Ctrl+LeftDrag"));
    assert!(!masked("LeftStickDown", "LeftShoulder+LeftStickUp"));
    assert!(!masked("ShiftLeft", "Shift+LeftDrag"));
}

#[test]
fn panels_take_what_they_use() {
    let takes = |panel: &str, scene: &str| binding(panel).takes_from(&binding(scene));
    assert!(takes("ArrowUp", "ArrowUp"));
    assert!(takes("Shift+Tab", "ShiftLeft|Space"));
    assert!(takes("Right.Trigger", "Right.Trigger+Right.Stick"));
    assert!(takes("LeftStickDown", "LeftStick"));
    assert!(!takes("ArrowUp", "ArrowDown"));
}
