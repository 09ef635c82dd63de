//! Bindings as a file that people write and read.

use std::fmt::Write as _;

use farlight_ron::{FileError, parse};

use crate::{ActionBindings, Binding, Bindings, Context, Device, Preset, Sensitivity};

/// Longest text of a file of bindings, in bytes.
pub const MAX_FILE: usize = 1 << 20;

impl Bindings {
    /// Reads `ControlsSettings(...)`. It may be well formed and still make no sense:
    /// [`check`](Self::check) it.
    ///
    /// # Errors
    /// Says where something is that doesn't belong there.
    pub fn from_ron(text: &str) -> Result<Self, FileError> {
        if text.len() > MAX_FILE {
            let message = format!("longer than {MAX_FILE} bytes");
            return Err(FileError { line: 1, column: 1, field: String::new(), message });
        }
        parse(text)
    }

    /// Writes what differs from the defaults, with a few words at the head.
    pub fn to_ron(&self) -> String {
        let mut text = String::from(HEAD);
        let Self { preset, invert_zoom, invert_look, sensitivity, unused, bindings } =
            self.without_defaults();
        text += "ControlsSettings(\n";
        if preset != Preset::default() {
            let _ = writeln!(text, "    preset: {preset:?},");
        }
        if invert_zoom {
            text += "    invert_zoom: true,\n";
        }
        if invert_look {
            text += "    invert_look: true,\n";
        }
        if sensitivity != Sensitivity::default() {
            let _ = writeln!(text, "    sensitivity: {:?},", sensitivity.0);
        }
        names(&mut text, &unused);
        if !bindings.is_empty() {
            text += "    bindings: {\n";
            for (name, own) in &bindings {
                action(&mut text, name, own);
            }
            text += "    },\n";
        }
        text + ")\n"
    }
}

const HEAD: &str = "\
// Controls: what differs from the defaults. `farlight controls defaults` writes all of them,
// `farlight check FILE` says what is wrong in this file and which inputs do two things at once.
";

/// The actions that no device does, as many on a line as fit.
fn names(text: &mut String, unused: &[String]) {
    if unused.is_empty() {
        return;
    }
    let names: Vec<_> =
        unused.iter().map(|name| ron::to_string(name).unwrap_or_default()).collect();
    let line = format!("    unused: [{}],\n", names.join(", "));
    if line.chars().count() <= 100 {
        *text += &line;
        return;
    }
    *text += "    unused: [";
    let mut length = usize::MAX;
    for name in names {
        let more = name.chars().count() + 2;
        if length.saturating_add(more) > 100 {
            *text += "\n       ";
            length = 7;
        }
        let _ = write!(text, " {name},");
        length += more;
    }
    *text += "\n    ],\n";
}

/// A list as files have it.
pub(crate) fn list(bindings: &[Binding]) -> String {
    let items: Vec<_> = bindings.iter().map(item).collect();
    format!("[{}]", items.join(", "))
}

fn item(binding: &Binding) -> String {
    let plain = Binding::new(binding.source);
    let mut text = format!("\"{}\"", binding.input_text());
    if binding.is_plain() {
        return text;
    }
    text.insert_str(0, "(input: ");
    let Binding { dead_zone, curve, scale, invert_x, invert_y, .. } = binding;
    for (name, value, usual) in [
        ("dead_zone", dead_zone, plain.dead_zone),
        ("curve", curve, plain.curve),
        ("scale", scale, plain.scale),
    ] {
        if *value != usual {
            let _ = write!(text, ", {name}: {value:?}");
        }
    }
    for (name, value) in [("invert_x", invert_x), ("invert_y", invert_y)] {
        if *value {
            let _ = write!(text, ", {name}: true");
        }
    }
    text + ")"
}

/// A line an action, or one a device if there is too much.
fn action(text: &mut String, name: &str, own: &ActionBindings) {
    let name = ron::to_string(name).unwrap_or_default();
    let devices: Vec<_> = own
        .lists()
        .filter_map(|(device, bindings)| Some((device, bindings.as_ref()?)))
        .map(|(device, bindings)| (format!("{device}: {}", list(bindings)), bindings))
        .collect();
    let texts: Vec<_> = devices.iter().map(|(text, _)| text.as_str()).collect();
    let line = format!("        {name}: ({}),\n", texts.join(", "));
    if line.chars().count() <= 100 {
        *text += &line;
        return;
    }
    let _ = writeln!(text, "        {name}: (");
    for (line, bindings) in devices {
        if line.chars().count() <= 87 {
            let _ = writeln!(text, "            {line},");
            continue;
        }
        let device = line.split(':').next().unwrap_or_default();
        let _ = writeln!(text, "            {device}: [");
        for binding in bindings {
            let _ = writeln!(text, "                {},", item(binding));
        }
        *text += "            ],\n";
    }
    *text += "        ),\n";
}

/// A file with everything as it is by default, to be changed: every action with its label, its unit
/// and its inputs on all devices.
pub fn defaults_ron(preset: Preset) -> String {
    let bindings = Bindings { preset, ..Bindings::default() };
    let mut text = format!("{DEFAULTS_HEAD}ControlsSettings(\n");
    let _ = writeln!(
        text,
        "    // Viewer: an object in front of you. Room: one that you walk about in."
    );
    let _ = writeln!(text, "    preset: {preset:?},");
    text += "    // Zooming goes the other way.\n    invert_zoom: false,\n";
    text += "    // Looking up and down is exchanged.\n    invert_look: false,\n";
    text += "    // Factor on all that moves, 0.05 to 20.\n    sensitivity: 1.0,\n";
    text +=
        "    // Actions that no device does by default: only what `bindings` give them counts.\n";
    text += "    unused: [],\n    bindings: {\n";
    let mut context = None;
    for info in crate::ACTIONS {
        if context != Some(info.context) {
            context = Some(info.context);
            text += match info.context {
                Context::Scene => "        // Heard while no panel has the input.\n",
                Context::Global => "\n        // Always heard.\n",
                Context::Panel => "\n        // Heard while a panel is open and has the focus.\n",
            };
        }
        let unit = if info.unit.is_empty() { String::new() } else { format!(" ({})", info.unit) };
        let _ = writeln!(text, "        // {}{unit}", info.label);
        let mut own = ActionBindings::default();
        for device in Device::ALL {
            let list = bindings.of(info.name, device);
            *own.own_mut(device) = (!list.is_empty()).then_some(list);
        }
        if own == ActionBindings::default() {
            let _ = writeln!(text, "        // {:?}: (),", info.name);
        } else {
            action(&mut text, info.name, &own);
        }
    }
    text + "    },\n)\n"
}

const DEFAULTS_HEAD: &str = "\
// Controls: everything as it is by default. Keep what you change; what is left out stays as it is. An
// empty list binds nothing; `unused` takes an action from all devices. Inputs are keys by their place
// (KeyM, ArrowLeft, F1), MouseLeft, LeftDrag, Wheel, South, LeftStick, LeftTrigger, WiiA,
// OneFingerDrag, Left.Trigger, Right.Stick; KeyA|KeyD is less and more, KeyA|KeyD|KeyS|KeyW left,
// right, down and up; Shift+, Ctrl+, Alt+ or any button and a + before it must be held.
// (input: \"LeftStick\", dead_zone: 0.15, curve: 2.0, scale: 120.0) treats values: what is held gives
// scale a second, what moves gives scale for each unit of its own. `xr: [...]` is for all controllers
// of headsets that have the input; xr_touch, xr_index, xr_vive, xr_simple and xr_hands go before it.
";
