//! The documentation's tables: all actions by device.

use std::fmt::Write as _;

use crate::{ACTIONS, ActionInfo, ActionKind, Bindings, Context, Device, Preset, Profile};

/// Actions of Schiller, *BTF Rendering in Virtual Reality*, 2022, appendix A, and how that
/// application is told to do them with keyboard and mouse.
#[rustfmt::skip]
pub const APPENDIX_A: &[(&str, &str)] = &[
    ("orbit", "left drag"), ("zoom", "wheel"), ("walk", "W, A, S, D"), ("rise", "Space, left Shift"),
    ("rotate_object", "middle drag"), ("rotate_environment", "right drag"),
    ("next_material", "right arrow"), ("previous_material", "left arrow"),
    ("next_model", "8"), ("previous_model", "5"), ("more_lights", "up arrow"),
    ("fewer_lights", "down arrow"), ("toggle_progressive", "P"), ("toggle_image_based", "N"),
    ("evaluation_1", "1"), ("evaluation_2", "2"), ("evaluation_3", "3"), ("finer_picture", "6"),
    ("coarser_picture", "4"), ("finer_material", "+"), ("coarser_material", "-"), ("recentre", "I"),
    ("menu", "M"), ("screenshot", "U"), ("xr_screenshot", "O"), ("quit", "Esc"),
];

const DESK: &[Device] = &[Device::KeyboardMouse, Device::Gamepad, Device::Touch, Device::WiiRemote];

const HEADSET: &[Device] = &[
    Device::Xr(Profile::Touch),
    Device::Xr(Profile::Index),
    Device::Xr(Profile::Vive),
    Device::Xr(Profile::Simple),
    Device::Xr(Profile::Hands),
];

/// All actions by device as a Markdown table, under these bindings. `added` are the game's own
/// actions.
pub fn table(bindings: &Bindings, devices: &[Device], added: &[ActionInfo]) -> String {
    let mut text = head("action | file", devices);
    for info in ACTIONS.iter().chain(added) {
        let _ = write!(text, "| {} | `{}` |", info.label, info.name);
        for device in devices {
            let _ = write!(text, " {} |", cell(bindings, info, *device));
        }
        text.push('\n');
    }
    text
}

fn head(first: &str, devices: &[Device]) -> String {
    let labels: Vec<_> = devices
        .iter()
        .map(|device| match device {
            Device::WiiRemote => "Wii Remote (unverified)",
            device => device.label(),
        })
        .collect();
    let columns = first.split('|').count() + devices.len();
    format!("| {first} | {} |\n|{}\n", labels.join(" | "), "---|".repeat(columns))
}

fn inputs(bindings: &Bindings, info: &ActionInfo, device: Device) -> String {
    let bound = bindings.of(info.name, device);
    let labels: Vec<_> =
        bound.iter().map(|binding| binding.label_on(device).replace('|', "\\|")).collect();
    labels.join(", ")
}

/// How an action is reached with a device.
fn cell(bindings: &Bindings, info: &ActionInfo, device: Device) -> String {
    let direct = inputs(bindings, info, device);
    if !direct.is_empty() {
        return direct;
    }
    let room = Bindings { preset: Preset::Room, ..bindings.clone() };
    let in_room = inputs(&room, info, device);
    let of_headsets = matches!(info.name, "teleport" | "turn_left" | "turn_right")
        || matches!(info.name, "grab_left" | "grab_right");
    match (info.context, device) {
        _ if !in_room.is_empty() => format!("in a room: {in_room}"),
        // Not in a menu either.
        _ if bindings.is_unused(info.name) => "-".into(),
        // The panel is pointed at, or touched.
        (Context::Panel, Device::Touch | Device::Xr(_)) => "on the panel".into(),
        // A game knows whether its own actions are in a menu.
        _ if of_headsets || crate::action(info.name).is_none() => "-".into(),
        (Context::Scene, Device::Xr(_)) if info.kind != ActionKind::Button => {
            "with the head".into()
        }
        // A menu chooses; it doesn't move.
        (Context::Panel, _) => "-".into(),
        _ if info.kind != ActionKind::Button => "-".into(),
        _ => "menu".into(),
    }
}

/// The tables of `docs/controls.md`: appendix A of the thesis, all actions on a desk and in a
/// headset, and what is different in a room.
pub fn documentation() -> String {
    let viewer = Bindings::default();
    let room = Bindings { preset: Preset::Room, ..Bindings::default() };
    let mut text = String::from("### Appendix A of the thesis\n\n");
    let devices = &[Device::KeyboardMouse, Device::Gamepad, Device::Xr(Profile::Touch)];
    text += &head("action | there", devices);
    for (name, there) in APPENDIX_A {
        let Some(info) = crate::action(name) else { continue };
        let _ = write!(text, "| {} | {there} |", info.label);
        for device in devices {
            let _ = write!(text, " {} |", cell(&viewer, info, *device));
        }
        text.push('\n');
    }
    let _ = write!(text, "\n### On a desk\n\n{}", table(&viewer, DESK, &[]));
    let _ = write!(text, "\n### In a headset\n\n{}", table(&viewer, HEADSET, &[]));
    text += "\n### In a room\n\nWhat `preset: Room` has instead.\n\n";
    text += "| device | action | inputs |\n|---|---|---|\n";
    for device in Device::ALL {
        for info in ACTIONS {
            let [before, after] = [&viewer, &room].map(|b| inputs(b, info, device));
            if before != after {
                let after = if after.is_empty() { "-" } else { &after };
                let _ = writeln!(text, "| {device} | {} | {after} |", info.label);
            }
        }
    }
    text
}
