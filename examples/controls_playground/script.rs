//! Somebody who uses each kind of device once, through Bevy's own messages.

use bevy::{
    input::{
        ButtonState,
        gamepad::{
            GamepadConnection, GamepadConnectionEvent, RawGamepadAxisChangedEvent,
            RawGamepadButtonChangedEvent, RawGamepadEvent,
        },
        keyboard::{Key, KeyboardInput},
        mouse::{MouseButtonInput, MouseMotion},
        touch::{TouchInput, TouchPhase},
    },
    prelude::*,
};
use farlight::controls::XrControllers;
use farlight_bindings::{Hand, Profile, Xr};

/// Kinds of devices, as pictures are called.
pub const KINDS: [&str; 4] = ["keyboard_mouse", "gamepad", "touch", "xr_touch"];
/// Frames of each.
pub const FRAMES: u32 = 48;

/// A device that is being used.
pub struct Script {
    kind: &'static str,
    window: Entity,
    pad: Entity,
}

impl Script {
    /// Takes a device in hand.
    pub fn new(world: &mut World, kind: &'static str) -> Self {
        let (window, pad) = (world.spawn_empty().id(), world.spawn_empty().id());
        if kind == "gamepad" {
            let connection = GamepadConnection::Connected {
                name: "Example pad".into(),
                vendor_id: None,
                product_id: None,
            };
            let event = GamepadConnectionEvent::new(pad, connection);
            world.write_message(event.clone());
            world.write_message(RawGamepadEvent::from(event));
        }
        Self { kind, window, pad }
    }

    /// A frame of it.
    pub fn frame(&self, world: &mut World, frame: u32) {
        match self.kind {
            "gamepad" => self.gamepad(world, frame),
            "touch" => self.touch(world, frame),
            "xr_touch" => Self::hands(world, frame),
            _ => self.desk(world, frame),
        }
    }

    fn key(&self, world: &mut World, key_code: KeyCode, down: bool) {
        let state = if down { ButtonState::Pressed } else { ButtonState::Released };
        let (window, logical_key) = (self.window, Key::Dead(None));
        world.write_message(KeyboardInput {
            key_code,
            logical_key,
            state,
            text: None,
            repeat: false,
            window,
        });
    }

    fn desk(&self, world: &mut World, frame: u32) {
        let button =
            |state| MouseButtonInput { button: MouseButton::Left, state, window: self.window };
        match frame {
            2 => self.key(world, KeyCode::ArrowRight, true),
            4 => self.key(world, KeyCode::ArrowRight, false),
            8 => {
                world.write_message(button(ButtonState::Pressed));
            }
            30 => self.key(world, KeyCode::Slash, true),
            44 => self.key(world, KeyCode::BracketRight, true),
            _ => {}
        }
        if frame > 8 {
            world.write_message(MouseMotion { delta: Vec2::new(-3.0, 1.0) });
        }
    }

    fn gamepad(&self, world: &mut World, frame: u32) {
        let mut axis = |axis, value| {
            let event = RawGamepadAxisChangedEvent::new(self.pad, axis, value);
            world.write_message(RawGamepadEvent::from(event));
        };
        match frame {
            4 => axis(GamepadAxis::LeftStickX, 0.8),
            8 => {
                axis(GamepadAxis::RightStickX, -0.9);
                axis(GamepadAxis::RightStickY, 0.4);
            }
            _ => {}
        }
        let mut button = |button, value| {
            let event = RawGamepadButtonChangedEvent::new(self.pad, button, value);
            world.write_message(RawGamepadEvent::from(event));
        };
        match frame {
            20 | 40 => button(GamepadButton::East, 1.0),
            22 => button(GamepadButton::East, 0.0),
            30 => button(GamepadButton::RightTrigger2, 0.6),
            44 => button(GamepadButton::North, 1.0),
            _ => {}
        }
    }

    fn touch(&self, world: &mut World, frame: u32) {
        let mut finger = |id, phase, x: f32, y: f32| {
            let position = Vec2::new(x, y);
            world.write_message(TouchInput {
                phase,
                position,
                window: self.window,
                force: None,
                id,
            });
        };
        let t = frame as f32;
        match frame {
            2 => finger(1, TouchPhase::Started, 500.0, 400.0),
            20 => finger(2, TouchPhase::Started, 760.0, 400.0),
            3..20 => finger(1, TouchPhase::Moved, 500.0 + 4.0 * t, 400.0 - t),
            21.. => {
                finger(1, TouchPhase::Moved, 580.0 - t, 380.0 - t);
                finger(2, TouchPhase::Moved, 740.0 + 2.0 * t, 400.0 - t);
            }
            _ => {}
        }
    }

    fn hands(world: &mut World, frame: u32) {
        let mut hands = world.resource_mut::<XrControllers>();
        for hand in Hand::ALL {
            hands.hand_mut(hand).profile = Some(Profile::Touch);
        }
        let mut say = |hand, input, x: f32, y: f32| {
            hands.hand_mut(hand).values.insert(input, Vec2::new(x, y));
        };
        match frame {
            4 => say(Hand::Left, Xr::Stick, 0.7, -0.3),
            10 => say(Hand::Right, Xr::Stick, -0.8, 0.5),
            20 | 42 => say(Hand::Right, Xr::Primary, 1.0, 0.0),
            24 => say(Hand::Right, Xr::Primary, 0.0, 0.0),
            44 => say(Hand::Right, Xr::Squeeze, 1.0, 0.0),
            _ => {}
        }
    }
}
