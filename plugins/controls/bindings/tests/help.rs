//! What people read.

use farlight_bindings::{
    ACTIONS, ActionInfo, ActionKind, Binding, Bindings, Context, Device, Direction, HelpLine,
    Preset, Profile, first_hint, help, help_text,
};

fn label(text: &str) -> String {
    text.parse::<Binding>().unwrap().label_on(Device::Xr(Profile::Touch))
}

#[test]
fn inputs_have_short_names() {
    for (text, words) in [
        ("KeyM", "M"),
        ("Ctrl+LeftDrag", "Ctrl + left drag"),
        ("KeyA|KeyD|KeyS|KeyW", "W A S D"),
        ("ArrowLeft|ArrowRight|ArrowDown|ArrowUp", "arrows"),
        ("LeftShoulder+DPadLeft|DPadRight|DPadDown|DPadUp", "left shoulder + D-pad"),
        ("RightStickDown|RightStickUp", "right stick down / up"),
        ("LeftTrigger|RightTrigger", "left trigger / right trigger"),
        ("Left.TrackpadClick+Left.TrackpadUp", "press left trackpad up"),
        ("Left.Squeeze+Right.TrackpadClick+Right.Trackpad", "left grip + press right trackpad"),
        ("Left.Trigger+Right.Primary", "left trigger + right A"),
        ("Left.Primary|Left.Secondary", "left X / left Y"),
        ("Left.TrackpadClick+Right.Trackpad", "left trackpad pressed + right trackpad"),
    ] {
        assert_eq!(label(text), words);
    }
    let binding: Binding = "Left.Primary".parse().unwrap();
    assert_eq!(binding.label_on(Device::Xr(Profile::Index)), "left A");
}

#[test]
fn every_bound_action_has_its_line() {
    for preset in Preset::ALL {
        let bindings = Bindings { preset, ..Bindings::default() };
        for device in Device::ALL {
            let lines = help(&bindings, device, &[]);
            let text = help_text(&bindings, device, &[]);
            for info in ACTIONS {
                for binding in bindings.of(info.name, device) {
                    let last = binding.source.inputs().last().unwrap().label_on(device);
                    let last = last.rsplit(' ').next().unwrap().to_owned();
                    assert!(
                        lines.iter().any(|line| line.inputs.contains(&last)),
                        "{device}: {info}"
                    );
                }
            }
            // No heading comes twice, so that an overlay can show them as they come.
            let mut groups: Vec<_> = lines.iter().map(|line| line.group).collect();
            groups.dedup();
            let count = groups.len();
            groups.sort_unstable();
            groups.dedup();
            assert_eq!(groups.len(), count, "{device}");
            assert!(groups.contains(&"Menu"), "{device}");
            assert!(lines.len() <= 40 && text.lines().count() <= 55, "{device}: too long to show");
        }
    }
}

#[test]
fn what_belongs_together_shares_a_line() {
    let bindings = Bindings::default();
    let line = |device, action: &str| -> HelpLine {
        help(&bindings, device, &[]).into_iter().find(|line| line.action == action).unwrap()
    };
    let HelpLine { group, label, inputs, .. } = line(Device::Gamepad, "next_environment");
    assert_eq!((group, label), ("Things", "Next, previous environment"));
    assert_eq!(inputs, "left shoulder + B (circle) / X (square)");
    let ways = line(Device::KeyboardMouse, "evaluation_1").inputs;
    assert_eq!(ways, "1 / 2 / 3, Num 1 / Num 2 / Num 3");
    let ways = line(Device::Xr(Profile::Vive), "evaluation_1").inputs;
    assert_eq!(ways, "left grip + right grip + press right trackpad left / up / right");
    let models = line(Device::Xr(Profile::Touch), "next_model").inputs;
    assert_eq!(models, "right stick pressed / left trigger + right stick pressed");
    // Alone where the other one has no input.
    let next = line(Device::Touch, "next_material");
    assert_eq!((next.label, next.inputs.as_str()), ("Next material", "double tap"));
}

#[test]
fn help_follows_the_bindings_in_force() {
    let mut bindings = Bindings::default();
    bindings.set("menu", Device::KeyboardMouse, vec!["F2".parse().unwrap()]);
    bindings.set("help", Device::KeyboardMouse, vec![]);
    let jump = ActionInfo {
        name: "jump",
        label: "Jump",
        kind: ActionKind::Button,
        context: Context::Scene,
        unit: "",
    };
    bindings.set("jump", Device::KeyboardMouse, vec!["Space".parse().unwrap()]);
    let lines = help(&bindings, Device::KeyboardMouse, &[jump]);
    let has = |action: &str, inputs: &str| {
        lines.iter().any(|line| line.action == action && line.inputs == inputs)
    };
    assert!(has("menu", "F2") && has("jump", "Space"));
    assert!(lines.iter().all(|line| line.action != "help"));
    assert_eq!(first_hint(&bindings, Device::KeyboardMouse), "F2: menu");
}

#[test]
fn the_first_screen_says_where_the_controls_are() {
    let hint = |device| first_hint(&Bindings::default(), device);
    assert_eq!(hint(Device::KeyboardMouse), "M: menu, F1: help");
    assert_eq!(hint(Device::Gamepad), "Start: menu, Select: help");
    let touch = hint(Device::Touch);
    assert_eq!(touch, "Tap with two fingers: menu, tap with three fingers: help");
    assert_eq!(hint(Device::Xr(Profile::Vive)), "Left menu button: menu, right menu button: help");
    let mut none = Bindings::default();
    for action in ["menu", "help"] {
        none.set(action, Device::Gamepad, vec![]);
    }
    assert_eq!(first_hint(&none, Device::Gamepad), "");
}

#[test]
fn a_stick_goes_one_way_at_a_time() {
    let all = [Direction::Left, Direction::Right, Direction::Down, Direction::Up];
    for (stick, ways) in [
        ([0.0, 0.0], [0.0, 0.0, 0.0, 0.0]),
        ([0.8, 0.5], [0.0, 0.8, 0.0, 0.0]),
        ([-0.8, 0.5], [0.8, 0.0, 0.0, 0.0]),
        ([0.3, -0.9], [0.0, 0.0, 0.9, 0.0]),
        ([-0.3, 2.0], [0.0, 0.0, 0.0, 1.0]),
        ([f32::NAN, 0.5], [0.0, 0.0, 0.0, 0.0]),
    ] {
        assert_eq!(all.map(|way| way.of(stick)), ways, "{stick:?}");
    }
}
