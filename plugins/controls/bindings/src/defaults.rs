//! What is bound when nobody says otherwise. The keys are those of Schiller, *BTF Rendering in
//! Virtual Reality*, 2022, appendix A, where it names one.
//!
//! No gamepad or controller needs two buttons at once for what people do often, and both hands do
//! half of the work: what the users of that application asked for (section 8.1.3).

use crate::{Binding, Device};

/// What is bound to an action by default.
pub(crate) fn of(action: &str, device: Device) -> Vec<Binding> {
    let table = match device {
        Device::KeyboardMouse => KEYBOARD_MOUSE,
        _ => &[],
    };
    let rows = table.iter().filter(|row| row.0 == action);
    rows.filter_map(|&(_, input, scale)| {
        let binding: Binding = input.parse().ok()?;
        Some(Binding { scale, ..binding })
    })
    .collect()
}

/// Action, input, scale.
const KEYBOARD_MOUSE: &[(&str, &str, f32)] = &[
    ("orbit", "LeftDrag", 0.25),
    ("orbit", "Shift+ArrowLeft|ArrowRight|ArrowDown|ArrowUp", 60.0),
    ("pan", "Shift+LeftDrag", 1.0),
    ("zoom", "Wheel", 1.0),
    ("walk", "KeyA|KeyD|KeyS|KeyW", 1.5),
    ("rise", "ShiftLeft|Space", 1.0),
    ("rotate_object", "MiddleDrag", 0.25),
    ("rotate_environment", "RightDrag", 0.35),
    ("next_material", "ArrowRight", 1.0),
    ("previous_material", "ArrowLeft", 1.0),
    ("next_model", "Digit8", 1.0),
    ("previous_model", "Digit5", 1.0),
    ("next_environment", "KeyE", 1.0),
    ("previous_environment", "KeyQ", 1.0),
    ("next_lamps", "KeyL", 1.0),
    ("more_lights", "ArrowUp", 1.0),
    ("fewer_lights", "ArrowDown", 1.0),
    ("toggle_progressive", "KeyP", 1.0),
    ("toggle_image_based", "KeyN", 1.0),
    ("evaluation_1", "Digit1", 1.0),
    ("evaluation_2", "Digit2", 1.0),
    ("evaluation_3", "Digit3", 1.0),
    ("finer_picture", "Digit6", 1.0),
    ("coarser_picture", "Digit4", 1.0),
    ("finer_material", "Equal", 1.0),
    ("finer_material", "NumpadAdd", 1.0),
    ("coarser_material", "Minus", 1.0),
    ("coarser_material", "NumpadSubtract", 1.0),
    ("brighter", "PageUp", 1.0),
    ("darker", "PageDown", 1.0),
    ("toggle_backdrop", "KeyB", 1.0),
    ("toggle_floor", "KeyF", 1.0),
    ("toggle_turning", "KeyT", 1.0),
    ("recentre", "KeyI", 1.0),
    ("reset", "KeyR", 1.0),
    ("menu", "KeyM", 1.0),
    ("help", "F1", 1.0),
    ("screenshot", "KeyU", 1.0),
    ("xr_screenshot", "KeyO", 1.0),
    ("quit", "Escape", 1.0),
    ("panel_back", "Escape", 1.0),
];
