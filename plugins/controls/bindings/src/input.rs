//! What can be pressed, turned or touched.

use std::{fmt, str::FromStr};

use crate::{Device, Key, Profile};

/// How an input moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Down or up.
    Button,
    /// From 0 to 1, for as long as it is held.
    Analog,
    /// Two numbers from -1 to 1, to the right and up, for as long as it is held.
    Stick,
    /// One number: what was moved in this frame.
    Delta,
    /// Two numbers: what was moved in this frame, to the right and up.
    Delta2,
}

macro_rules! inputs {
    (
        $(#[$attribute:meta])* $type:ident;
        $($variant:ident, $name:literal, $label:literal, $shape:ident, $unit:literal;)*
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum $type {
            $(#[doc = $label] $variant,)*
        }

        impl $type {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// What files call it.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The one that files call `name`.
            pub fn named(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|input| input.name() == name)
            }

            /// What people read.
            pub const fn label(self) -> &'static str {
                match self { $(Self::$variant => $label,)* }
            }

            /// How it moves.
            pub const fn shape(self) -> Shape {
                match self { $(Self::$variant => Shape::$shape,)* }
            }

            /// What a value of 1 is.
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$variant => $unit,)* }
            }
        }
    };
}

inputs! {
    /// Inputs of a mouse.
    Mouse;
    Left, "MouseLeft", "left click", Button, "";
    Right, "MouseRight", "right click", Button, "";
    Middle, "MouseMiddle", "middle click", Button, "";
    Back, "MouseBack", "mouse back", Button, "";
    Forward, "MouseForward", "mouse forward", Button, "";
    Move, "MouseMove", "move the mouse", Delta2, "logical pixels";
    LeftDrag, "LeftDrag", "left drag", Delta2, "logical pixels";
    RightDrag, "RightDrag", "right drag", Delta2, "logical pixels";
    MiddleDrag, "MiddleDrag", "middle drag", Delta2, "logical pixels";
    Wheel, "Wheel", "wheel", Delta, "lines, away from you is positive";
}

inputs! {
    /// Inputs of a gamepad, by place: of the four buttons South is the lower one, which is called A, or is
    /// a cross.
    Pad;
    South, "South", "A (cross)", Button, "";
    East, "East", "B (circle)", Button, "";
    West, "West", "X (square)", Button, "";
    North, "North", "Y (triangle)", Button, "";
    LeftShoulder, "LeftShoulder", "left shoulder", Button, "";
    RightShoulder, "RightShoulder", "right shoulder", Button, "";
    LeftTrigger, "LeftTrigger", "left trigger", Analog, "";
    RightTrigger, "RightTrigger", "right trigger", Analog, "";
    LeftStick, "LeftStick", "left stick", Stick, "";
    RightStick, "RightStick", "right stick", Stick, "";
    LeftStickLeft, "LeftStickLeft", "left stick left", Analog, "";
    LeftStickRight, "LeftStickRight", "left stick right", Analog, "";
    LeftStickDown, "LeftStickDown", "left stick down", Analog, "";
    LeftStickUp, "LeftStickUp", "left stick up", Analog, "";
    RightStickLeft, "RightStickLeft", "right stick left", Analog, "";
    RightStickRight, "RightStickRight", "right stick right", Analog, "";
    RightStickDown, "RightStickDown", "right stick down", Analog, "";
    RightStickUp, "RightStickUp", "right stick up", Analog, "";
    LeftStickClick, "LeftStickClick", "left stick pressed", Button, "";
    RightStickClick, "RightStickClick", "right stick pressed", Button, "";
    DPadLeft, "DPadLeft", "D-pad left", Button, "";
    DPadRight, "DPadRight", "D-pad right", Button, "";
    DPadUp, "DPadUp", "D-pad up", Button, "";
    DPadDown, "DPadDown", "D-pad down", Button, "";
    Start, "Start", "Start", Button, "";
    Select, "Select", "Select", Button, "";
    Mode, "Mode", "middle button", Button, "";
}

inputs! {
    /// Inputs of a Wii Remote, as the Linux driver `hid-wiimote` names them.
    Wii;
    A, "WiiA", "A", Button, "";
    B, "WiiB", "B", Button, "";
    One, "WiiOne", "1", Button, "";
    Two, "WiiTwo", "2", Button, "";
    Plus, "WiiPlus", "plus", Button, "";
    Minus, "WiiMinus", "minus", Button, "";
    Home, "WiiHome", "Home", Button, "";
    Left, "WiiLeft", "cross left", Button, "";
    Right, "WiiRight", "cross right", Button, "";
    Up, "WiiUp", "cross up", Button, "";
    Down, "WiiDown", "cross down", Button, "";
}

inputs! {
    /// What fingers do.
    Touch;
    Drag, "OneFingerDrag", "drag with one finger", Delta2, "logical pixels";
    Drag2, "TwoFingerDrag", "drag with two fingers", Delta2, "logical pixels";
    Drag3, "ThreeFingerDrag", "drag with three fingers", Delta2, "logical pixels";
    Pinch, "TwoFingerPinch", "spread or pinch two fingers", Delta, "doublings of their distance";
    Twist, "Twist", "turn two fingers", Delta, "degrees, clockwise is positive";
    Tap, "Tap", "tap", Button, "";
    DoubleTap, "DoubleTap", "double tap", Button, "";
    Tap2, "TwoFingerTap", "tap with two fingers", Button, "";
    Tap3, "ThreeFingerTap", "tap with three fingers", Button, "";
    LongPress, "LongPress", "press and hold", Button, "";
}

inputs! {
    /// Inputs of a controller for one hand, or of a bare hand.
    Xr;
    Trigger, "Trigger", "trigger", Analog, "";
    Squeeze, "Squeeze", "grip", Analog, "";
    Stick, "Stick", "stick", Stick, "";
    StickLeft, "StickLeft", "stick left", Analog, "";
    StickRight, "StickRight", "stick right", Analog, "";
    StickDown, "StickDown", "stick down", Analog, "";
    StickUp, "StickUp", "stick up", Analog, "";
    StickClick, "StickClick", "stick pressed", Button, "";
    Trackpad, "Trackpad", "trackpad", Stick, "";
    TrackpadLeft, "TrackpadLeft", "trackpad left", Analog, "";
    TrackpadRight, "TrackpadRight", "trackpad right", Analog, "";
    TrackpadDown, "TrackpadDown", "trackpad down", Analog, "";
    TrackpadUp, "TrackpadUp", "trackpad up", Analog, "";
    TrackpadClick, "TrackpadClick", "trackpad pressed", Button, "";
    Primary, "Primary", "lower button (A, X)", Button, "";
    Secondary, "Secondary", "upper button (B, Y)", Button, "";
    Menu, "Menu", "menu button", Button, "";
    Select, "Select", "select button", Button, "";
    Pinch, "Pinch", "pinch", Analog, "";
    Grasp, "Grasp", "grasp", Analog, "";
    Swing, "Swing", "swing", Delta2, "degrees by which the hand's aim turned";
}

/// Left or right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Hand {
    /// The left hand.
    Left,
    /// The right hand.
    Right,
}

impl Hand {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Left, Self::Right];

    /// What files and people read.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Left => "Left",
            Self::Right => "Right",
        }
    }
}

/// Anything that can be pressed, turned or touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Input {
    /// A key.
    Key(Key),
    /// Of a mouse.
    Mouse(Mouse),
    /// Of a gamepad.
    Pad(Pad),
    /// Of a Wii Remote.
    Wii(Wii),
    /// Of a touch screen.
    Touch(Touch),
    /// Of a hand.
    Xr(Hand, Xr),
}

impl Input {
    /// Every input there is.
    pub fn all() -> impl Iterator<Item = Self> {
        let hands = Hand::ALL.into_iter();
        Key::all()
            .map(Self::Key)
            .chain(Mouse::ALL.iter().map(|&m| Self::Mouse(m)))
            .chain(Pad::ALL.iter().map(|&p| Self::Pad(p)))
            .chain(Wii::ALL.iter().map(|&w| Self::Wii(w)))
            .chain(Touch::ALL.iter().map(|&t| Self::Touch(t)))
            .chain(hands.flat_map(|hand| Xr::ALL.iter().map(move |&x| Self::Xr(hand, x))))
    }

    /// How it moves.
    pub fn shape(self) -> Shape {
        match self {
            Self::Key(_) => Shape::Button,
            Self::Mouse(mouse) => mouse.shape(),
            Self::Pad(pad) => pad.shape(),
            Self::Wii(wii) => wii.shape(),
            Self::Touch(touch) => touch.shape(),
            Self::Xr(_, xr) => xr.shape(),
        }
    }

    /// What people read.
    pub fn label(self) -> String {
        match self {
            Self::Key(key) => key.label().to_owned(),
            Self::Mouse(mouse) => mouse.label().to_owned(),
            Self::Pad(pad) => pad.label().to_owned(),
            Self::Wii(wii) => wii.label().to_owned(),
            Self::Touch(touch) => touch.label().to_owned(),
            Self::Xr(hand, xr) => format!("{} {}", hand.name().to_lowercase(), xr.label()),
        }
    }

    /// Whether a device has it.
    pub fn is_of(self, device: Device) -> bool {
        match (self, device) {
            (Self::Key(_) | Self::Mouse(_), Device::KeyboardMouse)
            | (Self::Pad(_), Device::Gamepad)
            | (Self::Wii(_), Device::WiiRemote)
            | (Self::Touch(_), Device::Touch) => true,
            (Self::Xr(_, Xr::Swing), Device::Xr(_)) => true,
            (Self::Xr(hand, xr), Device::Xr(profile)) => {
                let whole = match self.stick() {
                    Some((Self::Xr(_, stick), _)) => stick,
                    _ => xr,
                };
                profile.path(hand, whole).is_some()
            }
            _ => false,
        }
    }
}

/// The name in files: `KeyM`, `LeftDrag`, `LeftStick`, `WiiA`, `TwoFingerPinch`, `Right.Trigger`.
impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Key(key) => f.write_str(key.name()),
            Self::Mouse(mouse) => f.write_str(mouse.name()),
            Self::Pad(pad) => f.write_str(pad.name()),
            Self::Wii(wii) => f.write_str(wii.name()),
            Self::Touch(touch) => f.write_str(touch.name()),
            Self::Xr(hand, xr) => write!(f, "{}.{}", hand.name(), xr.name()),
        }
    }
}

impl FromStr for Input {
    type Err = UnknownInput;

    fn from_str(name: &str) -> Result<Self, UnknownInput> {
        let mouse = || Mouse::named(name).map(Self::Mouse);
        let hand = |hand: Hand| {
            let xr = name.strip_prefix(hand.name())?.strip_prefix('.')?;
            Xr::named(xr).map(|xr| Self::Xr(hand, xr))
        };
        Key::named(name)
            .map(Self::Key)
            .or_else(mouse)
            .or_else(|| Pad::named(name).map(Self::Pad))
            .or_else(|| Wii::named(name).map(Self::Wii))
            .or_else(|| Touch::named(name).map(Self::Touch))
            .or_else(|| Hand::ALL.into_iter().find_map(hand))
            .ok_or_else(|| UnknownInput(name.to_owned()))
    }
}

/// No input has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no input")]
pub struct UnknownInput(pub String);

impl Profile {
    /// OpenXR's path of the interaction profile.
    pub const fn path_of_profile(self) -> &'static str {
        match self {
            Self::Simple => "/interaction_profiles/khr/simple_controller",
            Self::Touch => "/interaction_profiles/oculus/touch_controller",
            Self::Index => "/interaction_profiles/valve/index_controller",
            Self::Vive => "/interaction_profiles/htc/vive_controller",
            Self::Hands => "/interaction_profiles/ext/hand_interaction_ext",
        }
    }

    /// OpenXR's path of an input below `/user/hand/left` or `/user/hand/right`, if the profile has it.
    #[rustfmt::skip]
    pub const fn path(self, hand: Hand, input: Xr) -> Option<&'static str> {
        Some(match (self, input) {
            (Self::Simple, Xr::Select) => "input/select/click",
            (Self::Simple | Self::Vive, Xr::Menu) => "input/menu/click",
            (Self::Touch, Xr::Menu) if matches!(hand, Hand::Left) => "input/menu/click",
            (Self::Touch | Self::Index | Self::Vive, Xr::Trigger) => "input/trigger/value",
            (Self::Touch | Self::Index, Xr::Squeeze) => "input/squeeze/value",
            (Self::Vive, Xr::Squeeze) => "input/squeeze/click",
            (Self::Touch | Self::Index, Xr::Stick) => "input/thumbstick",
            (Self::Touch | Self::Index, Xr::StickClick) => "input/thumbstick/click",
            (Self::Index | Self::Vive, Xr::Trackpad) => "input/trackpad",
            (Self::Vive, Xr::TrackpadClick) => "input/trackpad/click",
            // The Index's trackpad feels how hard it is pressed.
            (Self::Index, Xr::TrackpadClick) => "input/trackpad/force",
            (Self::Touch, Xr::Primary) if matches!(hand, Hand::Left) => "input/x/click",
            (Self::Touch, Xr::Secondary) if matches!(hand, Hand::Left) => "input/y/click",
            (Self::Touch | Self::Index, Xr::Primary) => "input/a/click",
            (Self::Touch | Self::Index, Xr::Secondary) => "input/b/click",
            (Self::Hands, Xr::Pinch) => "input/pinch_ext/value",
            (Self::Hands, Xr::Grasp) => "input/grasp_ext/value",
            _ => return None,
        })
    }
}
