//! What drivers call buttons, as Bevy calls them.

use bevy::prelude::*;
use farlight_bindings::Wii;

/// Which table of codes a device has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PadTable {
    /// What gilrs makes of it.
    #[default]
    Gamepad,
    /// A Wii Remote's, as Linux's driver has them.
    WiiRemote,
}

/// Key codes of Linux (`include/uapi/linux/input-event-codes.h`) that the driver `hid-wiimote` sends
/// (`drivers/hid/hid-wiimote-modules.c`, `wiimod_keys_map`). Unverified: no such device was at hand.
const WII: &[(u16, Wii)] = &[
    (105, Wii::Left),   // KEY_LEFT
    (106, Wii::Right),  // KEY_RIGHT
    (103, Wii::Up),     // KEY_UP
    (108, Wii::Down),   // KEY_DOWN
    (407, Wii::Plus),   // KEY_NEXT
    (412, Wii::Minus),  // KEY_PREVIOUS
    (0x101, Wii::One),  // BTN_1
    (0x102, Wii::Two),  // BTN_2
    (0x130, Wii::A),    // BTN_A
    (0x131, Wii::B),    // BTN_B
    (0x13c, Wii::Home), // BTN_MODE
];

impl PadTable {
    /// The button with a key code of Linux, if it isn't what gilrs says anyway.
    pub fn button(self, code: u16) -> Option<GamepadButton> {
        let Self::WiiRemote = self else { return None };
        let (_, wii) = WII.iter().find(|(known, _)| *known == code)?;
        Some(GamepadButton::Other(*wii as u8))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_button_of_a_wii_remote_has_a_code() {
        for wii in Wii::ALL {
            assert_eq!(WII.iter().filter(|(_, known)| known == wii).count(), 1, "{wii:?}");
        }
        assert_eq!(PadTable::WiiRemote.button(0x130), Some(GamepadButton::Other(Wii::A as u8)));
        assert_eq!(PadTable::Gamepad.button(0x130), None);
    }
}
