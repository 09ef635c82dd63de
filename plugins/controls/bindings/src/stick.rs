//! Sticks as four buttons.

use crate::{Input, Pad, Xr};

/// A direction into which a stick is pushed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// To the left.
    Left,
    /// To the right.
    Right,
    /// Towards the person.
    Down,
    /// Away from the person.
    Up,
}

impl Direction {
    /// What people read.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Down => "down",
            Self::Up => "up",
        }
    }

    /// How far a stick is pushed this way, 0 to 1. `stick` goes to the right and up, -1 to 1.
    ///
    /// Only the direction into which it is pushed most counts: nobody who goes down a menu changes a
    /// value by the way (Schiller, *BTF Rendering in Virtual Reality*, 2022, section 8.1.2, on the
    /// crosses of controllers).
    pub fn of(self, stick: [f32; 2]) -> f32 {
        let [x, y] = stick;
        let (along, across) = match self {
            Self::Left => (-x, y),
            Self::Right => (x, y),
            Self::Down => (-y, x),
            Self::Up => (y, x),
        };
        if along >= across.abs() { along.clamp(0.0, 1.0) } else { 0.0 }
    }
}

impl Input {
    /// The stick or trackpad that this is a direction of. Devices give the stick; its directions
    /// follow from [`Direction::of`].
    #[rustfmt::skip]
    pub const fn stick(self) -> Option<(Self, Direction)> {
        use Direction::{Down, Left, Right, Up};
        Some(match self {
            Self::Pad(Pad::LeftStickLeft) => (Self::Pad(Pad::LeftStick), Left),
            Self::Pad(Pad::LeftStickRight) => (Self::Pad(Pad::LeftStick), Right),
            Self::Pad(Pad::LeftStickDown) => (Self::Pad(Pad::LeftStick), Down),
            Self::Pad(Pad::LeftStickUp) => (Self::Pad(Pad::LeftStick), Up),
            Self::Pad(Pad::RightStickLeft) => (Self::Pad(Pad::RightStick), Left),
            Self::Pad(Pad::RightStickRight) => (Self::Pad(Pad::RightStick), Right),
            Self::Pad(Pad::RightStickDown) => (Self::Pad(Pad::RightStick), Down),
            Self::Pad(Pad::RightStickUp) => (Self::Pad(Pad::RightStick), Up),
            Self::Xr(hand, Xr::StickLeft) => (Self::Xr(hand, Xr::Stick), Left),
            Self::Xr(hand, Xr::StickRight) => (Self::Xr(hand, Xr::Stick), Right),
            Self::Xr(hand, Xr::StickDown) => (Self::Xr(hand, Xr::Stick), Down),
            Self::Xr(hand, Xr::StickUp) => (Self::Xr(hand, Xr::Stick), Up),
            Self::Xr(hand, Xr::TrackpadLeft) => (Self::Xr(hand, Xr::Trackpad), Left),
            Self::Xr(hand, Xr::TrackpadRight) => (Self::Xr(hand, Xr::Trackpad), Right),
            Self::Xr(hand, Xr::TrackpadDown) => (Self::Xr(hand, Xr::Trackpad), Down),
            Self::Xr(hand, Xr::TrackpadUp) => (Self::Xr(hand, Xr::Trackpad), Up),
            _ => return None,
        })
    }

    /// Whether moving this input moves the other one too: the same, a stick and a direction of it, or
    /// a button of the mouse and a drag with it.
    pub fn overlaps(self, other: Self) -> bool {
        use crate::{Mouse, Touch};
        let part = |whole: Self, part: Self| part.stick().is_some_and(|(stick, _)| stick == whole);
        let drag = |button: Self, drag: Self| {
            matches!(
                (button, drag),
                (Self::Mouse(Mouse::Left), Self::Mouse(Mouse::LeftDrag))
                    | (Self::Mouse(Mouse::Right), Self::Mouse(Mouse::RightDrag))
                    | (Self::Mouse(Mouse::Middle), Self::Mouse(Mouse::MiddleDrag))
                    | (
                        Self::Mouse(Mouse::Move),
                        Self::Mouse(Mouse::LeftDrag | Mouse::RightDrag | Mouse::MiddleDrag)
                    )
                    // The first tap of two is a tap.
                    | (Self::Touch(Touch::Tap), Self::Touch(Touch::DoubleTap))
            )
        };
        let either = |a, b| part(a, b) || drag(a, b);
        self == other || either(self, other) || either(other, self)
    }
}
