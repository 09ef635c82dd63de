//! Keys of a keyboard, by place: the names of <https://www.w3.org/TR/uievents-code/>, which are
//! Bevy's `KeyCode` too.

/// A key: an index into [`KEYS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Key(u8);

impl Key {
    /// The key that files call `name`.
    pub fn named(name: &str) -> Option<Self> {
        KEYS.iter().position(|(key, _)| *key == name).map(|index| Self(index as u8))
    }

    /// What files call it.
    pub fn name(self) -> &'static str {
        KEYS[usize::from(self.0)].0
    }

    /// What stands on it on an English keyboard.
    pub fn label(self) -> &'static str {
        KEYS[usize::from(self.0)].1
    }

    /// All keys.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..KEYS.len()).map(|index| Self(index as u8))
    }
}

/// Names and labels.
#[rustfmt::skip]
pub const KEYS: &[(&str, &str)] = &[
    ("KeyA", "A"), ("KeyB", "B"), ("KeyC", "C"), ("KeyD", "D"), ("KeyE", "E"), ("KeyF", "F"),
    ("KeyG", "G"), ("KeyH", "H"), ("KeyI", "I"), ("KeyJ", "J"), ("KeyK", "K"), ("KeyL", "L"),
    ("KeyM", "M"), ("KeyN", "N"), ("KeyO", "O"), ("KeyP", "P"), ("KeyQ", "Q"), ("KeyR", "R"),
    ("KeyS", "S"), ("KeyT", "T"), ("KeyU", "U"), ("KeyV", "V"), ("KeyW", "W"), ("KeyX", "X"),
    ("KeyY", "Y"), ("KeyZ", "Z"),
    ("Digit0", "0"), ("Digit1", "1"), ("Digit2", "2"), ("Digit3", "3"), ("Digit4", "4"),
    ("Digit5", "5"), ("Digit6", "6"), ("Digit7", "7"), ("Digit8", "8"), ("Digit9", "9"),
    ("Numpad0", "Num 0"), ("Numpad1", "Num 1"), ("Numpad2", "Num 2"), ("Numpad3", "Num 3"),
    ("Numpad4", "Num 4"), ("Numpad5", "Num 5"), ("Numpad6", "Num 6"), ("Numpad7", "Num 7"),
    ("Numpad8", "Num 8"), ("Numpad9", "Num 9"), ("NumpadAdd", "Num +"), ("NumpadSubtract", "Num -"),
    ("NumpadMultiply", "Num *"), ("NumpadDivide", "Num /"), ("NumpadDecimal", "Num ."),
    ("NumpadEnter", "Num Enter"),
    ("F1", "F1"), ("F2", "F2"), ("F3", "F3"), ("F4", "F4"), ("F5", "F5"), ("F6", "F6"),
    ("F7", "F7"), ("F8", "F8"), ("F9", "F9"), ("F10", "F10"), ("F11", "F11"), ("F12", "F12"),
    ("ArrowLeft", "Left arrow"), ("ArrowRight", "Right arrow"), ("ArrowUp", "Up arrow"),
    ("ArrowDown", "Down arrow"),
    ("Space", "Space"), ("Enter", "Enter"), ("Tab", "Tab"), ("Escape", "Esc"),
    ("Backspace", "Backspace"), ("Insert", "Insert"), ("Delete", "Delete"), ("Home", "Home"),
    ("End", "End"), ("PageUp", "Page Up"), ("PageDown", "Page Down"), ("CapsLock", "Caps Lock"),
    ("PrintScreen", "Print"), ("Pause", "Pause"), ("ContextMenu", "Menu key"),
    ("ShiftLeft", "Left Shift"), ("ShiftRight", "Right Shift"), ("ControlLeft", "Left Ctrl"),
    ("ControlRight", "Right Ctrl"), ("AltLeft", "Left Alt"), ("AltRight", "Right Alt"),
    ("SuperLeft", "Left Super"), ("SuperRight", "Right Super"),
    ("Minus", "-"), ("Equal", "="), ("BracketLeft", "["), ("BracketRight", "]"),
    ("Backslash", "\\"), ("Semicolon", ";"), ("Quote", "'"), ("Backquote", "`"), ("Comma", ","),
    ("Period", "."), ("Slash", "/"), ("IntlBackslash", "<"),
];
