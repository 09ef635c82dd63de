//! The device in hand.

use bevy::{prelude::*, time::Real};
use farlight_bindings::{Device, Input, Profile, Shape};

use crate::{
    gather::{Devices, Found},
    inputs::Inputs,
    sample::Sampling,
    slots::SLOTS,
};

/// The device that was used last; help is about it. It changes when another one is really used: a
/// button, half of a stick's way, the wheel, a finger; a mouse that trembles or a stick that doesn't
/// quite return changes nothing. It is written only when it changes, so that `Res::is_changed` tells.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct ActiveDevice {
    /// Its kind.
    pub device: Device,
    /// What it calls itself, if it does.
    pub name: Option<String>,
}

/// A mouse is used that moves this far in pixels, before half of it is forgotten.
const WANDER: f32 = 24.0;
/// Seconds in which half of a mouse's way is forgotten.
const FORGET: f32 = 0.25;

/// How far the mouse has moved of late, in pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wander(f32);

impl Wander {
    fn moves(&mut self, pixels: f32, seconds: f32) -> bool {
        self.0 = self.0 * 0.5f32.powf(seconds / FORGET) + pixels;
        let far = self.0 > WANDER;
        if far {
            self.0 = 0.0;
        }
        far
    }
}

/// Whose input it is.
fn of(input: Input, profile: Option<Profile>) -> Option<Device> {
    Some(match input {
        Input::Key(_) | Input::Mouse(_) => Device::KeyboardMouse,
        Input::Pad(_) => Device::Gamepad,
        Input::Wii(_) => Device::WiiRemote,
        Input::Touch(_) => Device::Touch,
        Input::Xr(..) => Device::Xr(profile?),
    })
}

/// The devices that are used in this frame; the one in hand stays if it is among them.
fn used(
    inputs: &Inputs,
    in_hand: Device,
    profile: Option<Profile>,
    moved: bool,
    fingers: bool,
) -> Device {
    let mut used = None;
    for slot in 0..SLOTS.len() {
        let input = SLOTS.input(slot);
        let wheel = input == Input::Mouse(farlight_bindings::Mouse::Wheel);
        let began = match input.shape() {
            Shape::Button | Shape::Analog => inputs.began(slot),
            _ => wheel && inputs.values[slot].x != 0.0,
        };
        if began {
            let device = of(input, profile);
            if device == Some(in_hand) {
                return in_hand;
            }
            used = device.or(used);
        }
    }
    if fingers {
        used = Some(Device::Touch);
    }
    if moved {
        used = used.or(Some(Device::KeyboardMouse));
    }
    used.unwrap_or(in_hand)
}

/// Finds out which device is in hand.
pub(crate) fn follow_device(
    sampling: Res<Sampling>,
    devices: Devices,
    time: Res<Time<Real>>,
    mut wander: Local<Wander>,
    mut active: ResMut<ActiveDevice>,
) {
    let Found { pad, profile, pads, remotes, fingers, pixels, .. } = sampling.found;
    let moved = wander.moves(pixels, time.delta_secs());
    let mut device = used(&sampling.inputs, active.device, profile, moved, fingers);
    device = match device {
        // Other controllers, or none any more.
        Device::Xr(_) => profile.map_or(Device::KeyboardMouse, Device::Xr),
        Device::Gamepad if pads == 0 => Device::KeyboardMouse,
        Device::WiiRemote if remotes == 0 => Device::KeyboardMouse,
        device => device,
    };
    let of_pad = matches!(device, Device::Gamepad | Device::WiiRemote);
    let name = if of_pad { pad.and_then(|pad| devices.name_of(pad)) } else { None };
    // Nobody touches it in this frame: it keeps its name.
    let same_name = active.name.as_deref() == name || (of_pad && pad.is_none());
    if active.device != device || !same_name {
        *active = ActiveDevice { device, name: name.map(str::to_owned) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mouse_that_trembles_is_not_used() {
        let mut wander = Wander::default();
        assert!((0..600).all(|_| !wander.moves(1.0, 1.0 / 60.0)));
        let mut wander = Wander::default();
        assert!((0..10).any(|_| wander.moves(8.0, 1.0 / 60.0)));
    }
}
