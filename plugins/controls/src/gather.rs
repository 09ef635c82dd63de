//! Reading devices as Bevy presents them.

use bevy::{
    ecs::system::SystemParam,
    input::{
        keyboard::KeyboardFocusLost,
        mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll, MouseScrollUnit},
        touch::TouchInput,
    },
    prelude::*,
};
use farlight_bindings::{Hand, Mouse, Pad, Profile, Touch, Wii};

use crate::{
    XrControllers,
    inputs::Inputs,
    slots::{Bases, SLOTS},
    touch::Fingers,
};

/// Bevy's devices.
#[derive(SystemParam)]
pub(crate) struct Devices<'w, 's> {
    keys: Option<Res<'w, ButtonInput<KeyCode>>>,
    buttons: Option<Res<'w, ButtonInput<MouseButton>>>,
    motion: Option<Res<'w, AccumulatedMouseMotion>>,
    scroll: Option<Res<'w, AccumulatedMouseScroll>>,
    pads: Query<'w, 's, (Entity, &'static Gamepad, Option<&'static Name>)>,
    lost: MessageReader<'w, 's, KeyboardFocusLost>,
    touches: MessageReader<'w, 's, TouchInput>,
    hands: Res<'w, XrControllers>,
}

#[rustfmt::skip]
const BUTTONS: &[(GamepadButton, Pad)] = &[
    (GamepadButton::South, Pad::South), (GamepadButton::East, Pad::East),
    (GamepadButton::West, Pad::West), (GamepadButton::North, Pad::North),
    (GamepadButton::LeftTrigger, Pad::LeftShoulder),
    (GamepadButton::RightTrigger, Pad::RightShoulder),
    (GamepadButton::LeftTrigger2, Pad::LeftTrigger),
    (GamepadButton::RightTrigger2, Pad::RightTrigger),
    (GamepadButton::LeftThumb, Pad::LeftStickClick),
    (GamepadButton::RightThumb, Pad::RightStickClick),
    (GamepadButton::DPadLeft, Pad::DPadLeft), (GamepadButton::DPadRight, Pad::DPadRight),
    (GamepadButton::DPadUp, Pad::DPadUp), (GamepadButton::DPadDown, Pad::DPadDown),
    (GamepadButton::Start, Pad::Start), (GamepadButton::Select, Pad::Select),
    (GamepadButton::Mode, Pad::Mode),
];

#[rustfmt::skip]
const STICKS: &[(GamepadAxis, GamepadAxis, Pad)] = &[
    (GamepadAxis::LeftStickX, GamepadAxis::LeftStickY, Pad::LeftStick),
    (GamepadAxis::RightStickX, GamepadAxis::RightStickY, Pad::RightStick),
];

/// Buttons of a Wii Remote for whoever maps them as those of a gamepad; the reader of this crate says
/// [`GamepadButton::Other`] with the place in [`Wii::ALL`].
#[rustfmt::skip]
const WII: &[(GamepadButton, Wii)] = &[
    (GamepadButton::South, Wii::A), (GamepadButton::East, Wii::B),
    (GamepadButton::Start, Wii::Plus), (GamepadButton::Select, Wii::Minus),
    (GamepadButton::Mode, Wii::Home), (GamepadButton::DPadLeft, Wii::Left),
    (GamepadButton::DPadRight, Wii::Right), (GamepadButton::DPadUp, Wii::Up),
    (GamepadButton::DPadDown, Wii::Down),
];

/// Whether a device is a Wii Remote: Nintendo's, RVL-CNT-01 or RVL-CNT-01-TR, or named as Linux's driver
/// names it (`drivers/hid/hid-wiimote-core.c`). Unverified: no such device was at hand.
pub(crate) fn is_wii_remote(vendor: Option<u16>, product: Option<u16>, name: &str) -> bool {
    (vendor == Some(0x057e) && matches!(product, Some(0x0306 | 0x0330)))
        || name.starts_with("Nintendo Wii Remote")
}

/// What reading has found beside the inputs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Found {
    /// The window has lost the focus.
    pub(crate) lost: bool,
    /// The gamepad that is being used.
    pub(crate) pad: Option<Entity>,
    /// How many gamepads there are.
    pub(crate) pads: u32,
    /// How many Wii Remotes there are.
    pub(crate) remotes: u32,
    /// Controllers of a headset.
    pub(crate) profile: Option<Profile>,
    /// Whether fingers are on the screen.
    pub(crate) fingers: bool,
    /// How far the mouse moved, in pixels.
    pub(crate) pixels: f32,
}

impl Devices<'_, '_> {
    /// Reads all of them. `seconds` have passed since the last frame; `panel` says that the pointer is on
    /// a panel.
    pub(crate) fn read(
        &mut self,
        bases: &Bases,
        inputs: &mut Inputs,
        fingers: &mut Fingers,
        seconds: f32,
        panel: bool,
    ) -> Found {
        inputs.clear();
        self.read_desk(bases, inputs);
        let mut found = Found {
            lost: self.lost.read().count() > 0,
            pixels: self.motion.as_ref().map_or(0.0, |motion| motion.delta.length()),
            profile: self.read_hands(bases, inputs),
            ..default()
        };
        self.read_pads(bases, inputs, &mut found);
        if found.lost {
            fingers.clear();
        }
        for event in self.touches.read() {
            fingers.hear(event);
        }
        let gesture = fingers.frame(seconds, panel);
        for touch in Touch::ALL {
            inputs.values[bases.touch(*touch)] = gesture.value(*touch);
        }
        found.fingers = fingers.any() || gesture.tap.is_some();
        found
    }

    /// Keyboard and mouse. What was pressed and let go within the frame was pressed.
    fn read_desk(&self, bases: &Bases, inputs: &mut Inputs) {
        let keys = self.keys.iter();
        for key in keys.flat_map(|keys| keys.get_pressed().chain(keys.get_just_pressed())) {
            if let Some(slot) = SLOTS.key(*key) {
                inputs.values[slot].x = 1.0;
            }
        }
        let (Some(buttons), Some(motion), Some(scroll)) =
            (&self.buttons, &self.motion, &self.scroll)
        else {
            return;
        };
        let moved = motion.delta * Vec2::new(1.0, -1.0);
        for (button, mouse, drag) in [
            (MouseButton::Left, Mouse::Left, Some(Mouse::LeftDrag)),
            (MouseButton::Right, Mouse::Right, Some(Mouse::RightDrag)),
            (MouseButton::Middle, Mouse::Middle, Some(Mouse::MiddleDrag)),
            (MouseButton::Back, Mouse::Back, None),
            (MouseButton::Forward, Mouse::Forward, None),
        ] {
            if buttons.pressed(button) || buttons.just_pressed(button) {
                inputs.values[bases.mouse(mouse)].x = 1.0;
                if let Some(drag) = drag {
                    inputs.values[bases.mouse(drag)] = moved;
                }
            }
        }
        inputs.values[bases.mouse(Mouse::Move)] = moved;
        let lines = match scroll.unit {
            MouseScrollUnit::Line => scroll.delta.y,
            MouseScrollUnit::Pixel => {
                scroll.delta.y / MouseScrollUnit::SCROLL_UNIT_CONVERSION_FACTOR
            }
        };
        inputs.values[bases.mouse(Mouse::Wheel)].x = lines;
    }

    /// Gamepads, as if they were one: of each input the strongest counts. The one with the strongest
    /// input is in use.
    fn read_pads(&self, bases: &Bases, inputs: &mut Inputs, found: &mut Found) {
        // A stick that doesn't quite return is not used.
        let mut strongest = (0.3, None);
        for (entity, pad, name) in &self.pads {
            let button = |button: GamepadButton| {
                let tapped = pad.pressed(button) || pad.just_pressed(button);
                let value = pad.get(button).unwrap_or(0.0).clamp(0.0, 1.0);
                // What was pressed and let go within the frame was pressed.
                if tapped && value < crate::inputs::PRESSED { 1.0 } else { value }
            };
            let mut note = |slot: usize, value: Vec2| {
                let value =
                    if value.is_finite() { value.clamp_length_max(1.0) } else { Vec2::ZERO };
                if value.length() > inputs.values[slot].length() {
                    inputs.values[slot] = value;
                }
                if value.length() > strongest.0 {
                    strongest = (value.length(), Some(entity));
                }
            };
            let name = name.map_or("", |name| name.as_str());
            if is_wii_remote(pad.vendor_id(), pad.product_id(), name) {
                for (at, wii) in Wii::ALL.iter().enumerate() {
                    let value = button(GamepadButton::Other(at as u8));
                    note(bases.wii(*wii), Vec2::new(value, 0.0));
                }
                for (from, wii) in WII {
                    note(bases.wii(*wii), Vec2::new(button(*from), 0.0));
                }
                found.remotes += 1;
                continue;
            }
            found.pads += 1;
            for (from, to) in BUTTONS {
                note(bases.pad(*to), Vec2::new(button(*from), 0.0));
            }
            for (x, y, to) in STICKS {
                let axis = |axis: GamepadAxis| pad.get(axis).unwrap_or(0.0);
                note(bases.pad(*to), Vec2::new(axis(*x), axis(*y)));
            }
        }
        found.pad = strongest.1;
    }

    /// The name of a gamepad.
    pub(crate) fn name_of(&self, pad: Entity) -> Option<&str> {
        self.pads.get(pad).ok()?.2.map(|name| name.as_str())
    }

    /// Controllers of a headset. Two of different kinds count as the right one's kind.
    fn read_hands(&self, bases: &Bases, inputs: &mut Inputs) -> Option<Profile> {
        for hand in Hand::ALL {
            let says = self.hands.hand(hand);
            if says.profile.is_none() {
                continue;
            }
            for (xr, value) in &says.values {
                if value.is_finite() {
                    inputs.values[bases.hand(hand, *xr)] = *value;
                }
            }
        }
        self.hands.hand(Hand::Right).profile.or(self.hands.hand(Hand::Left).profile)
    }
}
