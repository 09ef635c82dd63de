//! Defaults of what stands on a desk or lies in the hand.

use super::Table;

/// Mouse for what is looked at, left hand on W, A, S, D; every move is also on keys that need no
/// modifier: T, F, G, H look around; the keys round the comma turn the object, those round End the
/// light. Shift sinks (as in appendix A), so that no other binding asks for it.
#[rustfmt::skip]
pub(super) const KEYBOARD_MOUSE: Table = Table {
    rows: &[
        ("orbit", "LeftDrag", 0.25),
        ("orbit", "KeyF|KeyH|KeyG|KeyT", 60.0),
        ("pan", "Ctrl+LeftDrag", 1.0),
        ("zoom", "Wheel", 1.0),
        ("zoom", "KeyZ|KeyC", 8.0),
        ("walk", "KeyA|KeyD|KeyS|KeyW", 1.5),
        ("rise", "ShiftLeft|Space", 1.0),
        ("rotate_object", "MiddleDrag", 0.25),
        ("rotate_object", "Comma|Slash|Period|Semicolon", 60.0),
        ("rotate_environment", "RightDrag", 0.35),
        ("rotate_environment", "Delete|PageDown|End|Home", 60.0),
        ("next_material", "ArrowRight", 1.0),
        ("previous_material", "ArrowLeft", 1.0),
        ("next_model", "Digit8", 1.0),
        ("next_model", "Numpad8", 1.0),
        ("previous_model", "Digit5", 1.0),
        ("previous_model", "Numpad5", 1.0),
        ("next_environment", "KeyE", 1.0),
        ("previous_environment", "KeyQ", 1.0),
        ("next_lamps", "KeyL", 1.0),
        ("more_lights", "ArrowUp", 1.0),
        ("fewer_lights", "ArrowDown", 1.0),
        ("toggle_progressive", "KeyP", 1.0),
        ("toggle_image_based", "KeyN", 1.0),
        ("evaluation_1", "Digit1", 1.0),
        ("evaluation_1", "Numpad1", 1.0),
        ("evaluation_2", "Digit2", 1.0),
        ("evaluation_2", "Numpad2", 1.0),
        ("evaluation_3", "Digit3", 1.0),
        ("evaluation_3", "Numpad3", 1.0),
        ("finer_picture", "Digit6", 1.0),
        ("finer_picture", "Numpad6", 1.0),
        ("coarser_picture", "Digit4", 1.0),
        ("coarser_picture", "Numpad4", 1.0),
        ("finer_material", "Equal", 1.0),
        ("finer_material", "NumpadAdd", 1.0),
        ("coarser_material", "Minus", 1.0),
        ("coarser_material", "NumpadSubtract", 1.0),
        ("brighter", "BracketRight", 1.0),
        ("darker", "BracketLeft", 1.0),
        ("toggle_backdrop", "KeyB", 1.0),
        ("toggle_floor", "KeyV", 1.0),
        ("toggle_turning", "KeyX", 1.0),
        ("recentre", "KeyI", 1.0),
        ("reset", "KeyR", 1.0),
        ("menu", "KeyM", 1.0),
        ("help", "F1", 1.0),
        ("screenshot", "KeyU", 1.0),
        ("screenshot", "F12", 1.0),
        ("xr_screenshot", "KeyO", 1.0),
        ("quit", "Escape", 1.0),
        ("panel_press", "Enter", 1.0),
        ("panel_press", "NumpadEnter", 1.0),
        ("panel_press", "Space", 1.0),
        ("panel_next", "ArrowDown", 1.0),
        ("panel_next", "Tab", 1.0),
        ("panel_previous", "ArrowUp", 1.0),
        ("panel_previous", "Shift+Tab", 1.0),
        ("panel_more", "ArrowRight", 1.0),
        ("panel_less", "ArrowLeft", 1.0),
        ("panel_scroll", "PageDown|PageUp", 20.0),
        ("panel_back", "Escape", 1.0),
    ],
    room: &[],
};

/// Sticks, pad and triggers move; the four buttons change what is seen, as the arrows and 8 and 5 of
/// a keyboard do. The left shoulder held: where you are, and the light; the right one: the picture.
#[rustfmt::skip]
pub(super) const GAMEPAD: Table = Table {
    rows: &[
        ("orbit", "LeftStick", 120.0),
        ("rotate_object", "RightStick", 120.0),
        ("rotate_environment", "DPadLeft|DPadRight|DPadDown|DPadUp", 60.0),
        ("zoom", "LeftTrigger|RightTrigger", 12.0),
        ("next_material", "East", 1.0),
        ("previous_material", "West", 1.0),
        ("next_model", "North", 1.0),
        ("previous_model", "South", 1.0),
        ("recentre", "LeftStickClick", 1.0),
        ("toggle_turning", "RightStickClick", 1.0),
        ("menu", "Start", 1.0),
        ("help", "Select", 1.0),

        ("walk", "LeftShoulder+LeftStick", 2.0),
        ("pan", "LeftShoulder+RightStick", 600.0),
        ("rise", "LeftShoulder+LeftTrigger|RightTrigger", 1.0),
        ("next_environment", "LeftShoulder+East", 1.0),
        ("previous_environment", "LeftShoulder+West", 1.0),
        ("next_lamps", "LeftShoulder+North", 1.0),
        ("toggle_backdrop", "LeftShoulder+South", 1.0),
        ("more_lights", "LeftShoulder+DPadUp", 1.0),
        ("fewer_lights", "LeftShoulder+DPadDown", 1.0),
        ("toggle_image_based", "LeftShoulder+DPadLeft", 1.0),
        ("toggle_progressive", "LeftShoulder+DPadRight", 1.0),
        ("reset", "LeftShoulder+Start", 1.0),
        ("xr_screenshot", "LeftShoulder+Select", 1.0),

        ("coarser_picture", "RightShoulder+DPadLeft", 1.0),
        ("finer_picture", "RightShoulder+DPadRight", 1.0),
        ("finer_material", "RightShoulder+DPadUp", 1.0),
        ("coarser_material", "RightShoulder+DPadDown", 1.0),
        ("evaluation_1", "RightShoulder+West", 1.0),
        ("evaluation_2", "RightShoulder+North", 1.0),
        ("evaluation_3", "RightShoulder+East", 1.0),
        ("toggle_floor", "RightShoulder+South", 1.0),
        ("darker", "RightShoulder+LeftTrigger", 1.0),
        ("brighter", "RightShoulder+RightTrigger", 1.0),
        ("quit", "RightShoulder+Start", 1.0),
        ("screenshot", "RightShoulder+Select", 1.0),

        ("panel_press", "South", 1.0),
        ("panel_next", "DPadDown", 1.0),
        ("panel_next", "LeftStickDown", 1.0),
        ("panel_previous", "DPadUp", 1.0),
        ("panel_previous", "LeftStickUp", 1.0),
        ("panel_more", "DPadRight", 1.0),
        ("panel_more", "LeftStickRight", 1.0),
        ("panel_less", "DPadLeft", 1.0),
        ("panel_less", "LeftStickLeft", 1.0),
        ("panel_scroll", "RightStickDown|RightStickUp", 20.0),
        ("panel_back", "East", 1.0),
    ],
    room: &[
        ("walk", "LeftStick", 2.0),
        ("orbit", "RightStick", 120.0),
        ("rotate_object", "LeftShoulder+RightStick", 120.0),
        ("pan", "", 0.0),
    ],
};

/// Held upright in one hand, as in appendix A: the cross goes round. The buttons 1 and 2, which its
/// users found hard to reach, do what is seldom wanted. What is not here is in the menu.
#[rustfmt::skip]
pub(super) const WII_REMOTE: Table = Table {
    rows: &[
        ("orbit", "WiiLeft|WiiRight|WiiDown|WiiUp", 60.0),
        ("rotate_object", "WiiB+WiiLeft|WiiRight|WiiDown|WiiUp", 60.0),
        ("rotate_environment", "WiiA+WiiLeft|WiiRight|WiiDown|WiiUp", 60.0),
        ("zoom", "WiiMinus|WiiPlus", 8.0),
        ("next_material", "WiiB+WiiPlus", 1.0),
        ("previous_material", "WiiB+WiiMinus", 1.0),
        ("next_model", "WiiA+WiiPlus", 1.0),
        ("previous_model", "WiiA+WiiMinus", 1.0),
        ("screenshot", "WiiTwo", 1.0),
        ("menu", "WiiHome", 1.0),
        ("help", "WiiOne", 1.0),
        ("panel_press", "WiiA", 1.0),
        ("panel_next", "WiiDown", 1.0),
        ("panel_previous", "WiiUp", 1.0),
        ("panel_more", "WiiRight", 1.0),
        ("panel_less", "WiiLeft", 1.0),
        ("panel_scroll", "WiiMinus|WiiPlus", 20.0),
        ("panel_back", "WiiB", 1.0),
    ],
    room: &[
        ("walk", "WiiLeft|WiiRight|WiiDown|WiiUp", 1.5),
        ("orbit", "WiiA+WiiLeft|WiiRight|WiiDown|WiiUp", 60.0),
        ("rotate_environment", "", 0.0),
    ],
};

/// A doubling of two fingers' distance halves that to the object: log 2 / log (1 / 0.9) steps.
const STEPS_OF_A_DOUBLING: f32 = 6.58;

/// One finger looks, two turn the object, three the light. Panels are touched themselves.
#[rustfmt::skip]
pub(super) const TOUCH: Table = Table {
    rows: &[
        ("orbit", "OneFingerDrag", 0.25),
        ("rotate_object", "TwoFingerDrag", 0.25),
        ("rotate_environment", "ThreeFingerDrag", 0.35),
        ("zoom", "TwoFingerPinch", STEPS_OF_A_DOUBLING),
        ("next_material", "DoubleTap", 1.0),
        ("next_model", "LongPress", 1.0),
        ("menu", "TwoFingerTap", 1.0),
        ("help", "ThreeFingerTap", 1.0),
        ("panel_back", "TwoFingerTap", 1.0),
    ],
    room: &[
        ("walk", "TwoFingerDrag", 0.01),
        ("rotate_object", "", 0.0),
    ],
};
