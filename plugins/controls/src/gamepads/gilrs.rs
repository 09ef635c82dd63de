//! The machine's gamepads, by gilrs.

use std::{collections::VecDeque, time::Duration};

use bevy::prelude::{GamepadAxis, GamepadButton};
use gilrs::{
    Axis, Button, EventType, Filter as _, Gilrs, GilrsBuilder,
    ev::filter::axis_dpad_to_button,
    ff::{BaseEffect, BaseEffectType, Effect, EffectBuilder, Repeat, Replay},
};

use super::{PadEvent, PadRequest, PadSource, PadTable};
use crate::gather::is_wii_remote;

/// How long the thread waits for an event before it looks for requests.
const WAIT: Duration = Duration::from_millis(20);

/// Opens the machine's gamepads; may take long.
pub(super) fn open() -> Result<Box<dyn PadSource>, String> {
    let builder = GilrsBuilder::new().with_default_filters(false).set_update_state(false);
    let gilrs = builder.build().map_err(|error| error.to_string())?;
    let mut pads = Machine { gilrs, said: VecDeque::new(), effects: Vec::new() };
    let there: Vec<_> = pads.gilrs.gamepads().map(|(id, _)| id).collect();
    for id in there {
        let connected = pads.connected(id);
        pads.said.push_back(connected);
    }
    Ok(Box::new(pads))
}

struct Machine {
    gilrs: Gilrs,
    /// What is still to be said.
    said: VecDeque<PadEvent>,
    /// What shakes: it stops when its effect is dropped.
    effects: Vec<(usize, Effect)>,
}

impl Machine {
    fn connected(&self, id: gilrs::GamepadId) -> PadEvent {
        let pad = self.gilrs.gamepad(id);
        PadEvent::Connected {
            pad: id.into(),
            name: pad.name().to_owned(),
            vendor: pad.vendor_id(),
            product: pad.product_id(),
        }
    }

    fn table(&self, id: gilrs::GamepadId) -> PadTable {
        let pad = self.gilrs.gamepad(id);
        match is_wii_remote(pad.vendor_id(), pad.product_id(), pad.os_name()) {
            true => PadTable::WiiRemote,
            false => PadTable::Gamepad,
        }
    }
}

impl PadSource for Machine {
    fn next(&mut self) -> Option<PadEvent> {
        if let Some(said) = self.said.pop_front() {
            return Some(said);
        }
        let event = self.gilrs.next_event_blocking(Some(WAIT));
        let event = event.filter_ev(&axis_dpad_to_button, &mut self.gilrs)?;
        self.gilrs.update(&event);
        let pad = event.id.into();
        match event.event {
            EventType::Connected => Some(self.connected(event.id)),
            EventType::Disconnected => Some(PadEvent::Disconnected { pad }),
            EventType::ButtonChanged(button, value, code) => {
                // Of a code of Linux the lower half is the key's.
                let own = self.table(event.id).button(code.into_u32() as u16);
                let button = own.or_else(|| convert_button(button))?;
                Some(PadEvent::Button { pad, button, value })
            }
            EventType::AxisChanged(axis, value, _) => {
                Some(PadEvent::Axis { pad, axis: convert_axis(axis)?, value })
            }
            _ => None,
        }
    }

    fn request(&mut self, request: PadRequest) {
        match request {
            PadRequest::Stop { pad } => self.effects.retain(|(shaking, _)| *shaking != pad),
            PadRequest::Rumble { pad, duration, strong, weak } => {
                let id = self.gilrs.gamepads().map(|(id, _)| id).find(|id| usize::from(*id) == pad);
                let Some(id) = id else { return };
                let magnitude = |ratio: f32| (ratio.clamp(0.0, 1.0) * f32::from(u16::MAX)) as u16;
                let scheduling = Replay { play_for: duration.into(), ..Default::default() };
                let mut builder = EffectBuilder::new();
                for kind in [
                    BaseEffectType::Strong { magnitude: magnitude(strong) },
                    BaseEffectType::Weak { magnitude: magnitude(weak) },
                ] {
                    builder.add_effect(BaseEffect { kind, scheduling, ..Default::default() });
                }
                builder.repeat(Repeat::For(duration.into()));
                let effect = builder.gamepads(&[id]).finish(&mut self.gilrs);
                // One that can't shake doesn't.
                if let Ok(effect) = effect
                    && effect.play().is_ok()
                {
                    self.effects.retain(|(shaking, _)| *shaking != pad);
                    self.effects.push((pad, effect));
                }
            }
        }
    }
}

fn convert_button(button: Button) -> Option<GamepadButton> {
    Some(match button {
        Button::South => GamepadButton::South,
        Button::East => GamepadButton::East,
        Button::North => GamepadButton::North,
        Button::West => GamepadButton::West,
        Button::C => GamepadButton::C,
        Button::Z => GamepadButton::Z,
        Button::LeftTrigger => GamepadButton::LeftTrigger,
        Button::LeftTrigger2 => GamepadButton::LeftTrigger2,
        Button::RightTrigger => GamepadButton::RightTrigger,
        Button::RightTrigger2 => GamepadButton::RightTrigger2,
        Button::Select => GamepadButton::Select,
        Button::Start => GamepadButton::Start,
        Button::Mode => GamepadButton::Mode,
        Button::LeftThumb => GamepadButton::LeftThumb,
        Button::RightThumb => GamepadButton::RightThumb,
        Button::DPadUp => GamepadButton::DPadUp,
        Button::DPadDown => GamepadButton::DPadDown,
        Button::DPadLeft => GamepadButton::DPadLeft,
        Button::DPadRight => GamepadButton::DPadRight,
        Button::Unknown => return None,
    })
}

fn convert_axis(axis: Axis) -> Option<GamepadAxis> {
    Some(match axis {
        Axis::LeftStickX => GamepadAxis::LeftStickX,
        Axis::LeftStickY => GamepadAxis::LeftStickY,
        Axis::LeftZ => GamepadAxis::LeftZ,
        Axis::RightStickX => GamepadAxis::RightStickX,
        Axis::RightStickY => GamepadAxis::RightStickY,
        Axis::RightZ => GamepadAxis::RightZ,
        // The filter makes buttons of the D-pad's axes.
        Axis::DPadX | Axis::DPadY | Axis::Unknown => return None,
    })
}
