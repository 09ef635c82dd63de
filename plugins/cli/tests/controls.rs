//! `farlight controls`, and `farlight check` of bindings, as a user runs them.

mod support;

use std::process::{Command, Output};

use support::{Folder, refused, succeeded};

fn farlight(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_farlight")).args(arguments).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const FILE: &str = "\
ControlsSettings(
    bindings: {
        \"jump\": (keyboard_mouse: [\"Space\"]),
        \"reset\": (
            keyboard_mouse: [\"KeyM\"],
            gamepad: [(input: \"Mode\")],
        ),
    },
)
";

#[test]
fn a_good_file_is_good_and_conflicts_are_named() {
    let folder = Folder::new("controls-good");
    let file = folder.write("c.ron", FILE);
    let file = file.to_str().unwrap();
    let output = farlight(&["check", file]);
    assert_eq!(succeeded(&output), format!("{file}: good (ControlsSettings)\n"));
    let lines = [
        format!(
            "note: {file}:3:9: bindings.jump: no action of the suite; good if the game adds it under this name"
        ),
        format!("warning: {file}:5:13: Keyboard and mouse: KeyM does reset and menu at once"),
    ];
    assert_eq!(said(&output).lines().collect::<Vec<_>>(), lines);
    // The game says what it adds; then that is checked too.
    let output = farlight(&["check", "--actions", "jump,aim:axis2", file]);
    succeeded(&output);
    let said = said(&output);
    assert!(!said.contains("note:"), "{said}");
    assert!(
        said.contains("c.ron:3:18: Keyboard and mouse: ShiftLeft|Space does rise and jump"),
        "{said}"
    );
    let message = refused(&farlight(&["check", "--strict", file]));
    assert!(
        message.contains("error: ") && message.contains("KeyM does reset and menu"),
        "{message}"
    );
}

#[test]
fn errors_say_where_and_what_was_meant() {
    let folder = Folder::new("controls-bad");
    for (from, to, errors) in [
        (
            "\"reset\"",
            "\"rest\"",
            &["c.ron:4:9: bindings.rest: there is no such action; did you mean reset?"][..],
        ),
        (
            "Mode",
            "Mod",
            &[
                "c.ron:6:31: bindings.reset.gamepad[0].input: \"Mod\" is no input; did you mean Mode?",
            ],
        ),
        (
            "[\"KeyM\"]",
            "[(input: \"LeftDrag\", scale: 0), \"South\"]",
            &[
                "c.ron:5:30: bindings.reset.keyboard_mouse[0]: \"LeftDrag\" does not fit",
                "c.ron:5:50: bindings.reset.keyboard_mouse[0].scale: is 0",
                "c.ron:5:61: bindings.reset.keyboard_mouse[1]: South is no input of this device",
            ],
        ),
        (
            "    bindings",
            "    unused: [\"pan\", \"zom\"],\n    bindings",
            &["c.ron:2:21: unused[1]: \"zom\": there is no such action; did you mean zoom?"],
        ),
        (
            "gamepad",
            "gampad",
            &[
                "c.ron:6:13: bindings.reset.gampad: there is no field \"gampad\"; did you mean gamepad?",
            ],
        ),
    ] {
        let file = folder.write("c.ron", &FILE.replace(from, to));
        let message = refused(&farlight(&["check", file.to_str().unwrap()]));
        for error in errors {
            assert!(message.contains(error), "{message}");
        }
        assert_eq!(message.matches("error: ").count(), errors.len(), "{message}");
    }
}

#[test]
fn what_a_device_does_is_explained() {
    let folder = Folder::new("controls-help");
    let file = folder.write("c.ron", FILE);
    let file = file.to_str().unwrap();
    let help = succeeded(&farlight(&["controls", "help", "--device", "gamepad"]));
    assert!(help.starts_with("Gamepad. Start: menu, Select: help\n"), "{help}");
    assert!(help.contains("left shoulder + Start"), "{help}");
    let help = farlight(&["controls", "help", "--device", "gamepad", "--file", file]);
    let help = succeeded(&help);
    assert!(!help.contains("left shoulder + Start") && help.contains("middle button"), "{help}");
    let room =
        ["controls", "help", "--device", "xr-touch", "--preset", "room", "--actions", "jump"];
    let help = succeeded(&farlight(&room));
    assert!(help.contains("Teleport: hold, aim, let go  left stick up\n"), "{help}");

    let table =
        succeeded(&farlight(&["controls", "table", "--device", "gamepad", "--device", "touch"]));
    assert!(
        table.starts_with("| action | file | Gamepad | Touch screen |\n|---|---|---|---|\n"),
        "{table}"
    );
    assert!(table.contains("| Menu | `menu` | Start | tap with two fingers |\n"), "{table}");
    let all = succeeded(&farlight(&["controls", "table", "--file", file, "--actions", "jump"]));
    assert!(all.lines().all(|line| line.split('|').count() == 13), "{all}");
    assert!(all.contains("| jump | `jump` | Space | -"), "{all}");

    let message = refused(&farlight(&["controls", "help", "--device", "joystick"]));
    assert!(message.contains("there are keyboard_mouse, gamepad, wii_remote"), "{message}");
}

#[test]
fn the_defaults_are_a_good_file() {
    let folder = Folder::new("controls-defaults");
    for preset in ["viewer", "room"] {
        let text = succeeded(&farlight(&["controls", "defaults", "--preset", preset]));
        let file = folder.write("c.ron", &text);
        let output = farlight(&["check", "--strict", file.to_str().unwrap()]);
        succeeded(&output);
        assert_eq!(said(&output), "");
    }
}
