//! Devices that people hold.

use std::fmt;

/// Controllers that OpenXR knows how to describe: its interaction profiles
/// (<https://registry.khronos.org/OpenXR/specs/1.0/html/xrspec.html#semantic-path-interaction-profiles>).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Profile {
    /// What every runtime has: one button to select, one for the menu.
    Simple,
    /// Oculus Touch.
    Touch,
    /// Valve Index.
    Index,
    /// HTC Vive.
    Vive,
    /// Bare hands, tracked: pinch and grasp.
    Hands,
}

impl Profile {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Simple, Self::Touch, Self::Index, Self::Vive, Self::Hands];

    /// What people read.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Simple => "Simple controller",
            Self::Touch => "Touch controllers",
            Self::Index => "Index controllers",
            Self::Vive => "Vive wands",
            Self::Hands => "Hands",
        }
    }
}

/// A kind of device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub enum Device {
    /// Keyboard and mouse.
    #[default]
    KeyboardMouse,
    /// A gamepad with two sticks.
    Gamepad,
    /// A Wii Remote as Linux presents it. Unverified: no such device was at hand.
    WiiRemote,
    /// A touch screen.
    Touch,
    /// Controllers or hands in a headset.
    Xr(Profile),
}

impl Device {
    /// All of them, headset controllers by profile.
    pub const ALL: [Self; 9] = [
        Self::KeyboardMouse,
        Self::Gamepad,
        Self::WiiRemote,
        Self::Touch,
        Self::Xr(Profile::Simple),
        Self::Xr(Profile::Touch),
        Self::Xr(Profile::Index),
        Self::Xr(Profile::Vive),
        Self::Xr(Profile::Hands),
    ];

    /// What files and commands call it: `keyboard_mouse`, `xr_vive`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::KeyboardMouse => "keyboard_mouse",
            Self::Gamepad => "gamepad",
            Self::WiiRemote => "wii_remote",
            Self::Touch => "touch",
            Self::Xr(Profile::Simple) => "xr_simple",
            Self::Xr(Profile::Touch) => "xr_touch",
            Self::Xr(Profile::Index) => "xr_index",
            Self::Xr(Profile::Vive) => "xr_vive",
            Self::Xr(Profile::Hands) => "xr_hands",
        }
    }

    /// The device that files call `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|device| device.name() == name)
    }

    /// What people read.
    pub const fn label(self) -> &'static str {
        match self {
            Self::KeyboardMouse => "Keyboard and mouse",
            Self::Gamepad => "Gamepad",
            Self::WiiRemote => "Wii Remote",
            Self::Touch => "Touch screen",
            Self::Xr(profile) => profile.label(),
        }
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.label())
    }
}
