//! Which inputs do what, for every device.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    Binding, Device, Input, Preset, Profile, defaults,
    serial::{list, names, unique},
};

/// The inputs of an action, by device. An empty list binds nothing; what is left out stays as it is
/// by default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ActionBindings {
    /// Keyboard and mouse.
    #[serde(with = "list", skip_serializing_if = "Option::is_none")]
    pub keyboard_mouse: Option<Vec<Binding>>,
    /// Gamepads.
    #[serde(with = "list", skip_serializing_if = "Option::is_none")]
    pub gamepad: Option<Vec<Binding>>,
    /// Wii Remotes.
    #[serde(with = "list", skip_serializing_if = "Option::is_none")]
    pub wii_remote: Option<Vec<Binding>>,
    /// Touch screens.
    #[serde(with = "list", skip_serializing_if = "Option::is_none")]
    pub touch: Option<Vec<Binding>>,
    /// All controllers of headsets that have the input.
    #[serde(with = "list", skip_serializing_if = "Option::is_none")]
    pub xr: Option<Vec<Binding>>,
    /// Instead of `xr`, where a controller has one button to select and one for the menu.
    #[serde(with = "list", skip_serializing_if = "Option::is_none")]
    pub xr_simple: Option<Vec<Binding>>,
    /// Instead of `xr`, for Oculus Touch.
    #[serde(with = "list", skip_serializing_if = "Option::is_none")]
    pub xr_touch: Option<Vec<Binding>>,
    /// Instead of `xr`, for Valve Index.
    #[serde(with = "list", skip_serializing_if = "Option::is_none")]
    pub xr_index: Option<Vec<Binding>>,
    /// Instead of `xr`, for HTC Vive.
    #[serde(with = "list", skip_serializing_if = "Option::is_none")]
    pub xr_vive: Option<Vec<Binding>>,
    /// Instead of `xr`, for bare hands.
    #[serde(with = "list", skip_serializing_if = "Option::is_none")]
    pub xr_hands: Option<Vec<Binding>>,
}

impl ActionBindings {
    /// The list for exactly this device.
    pub fn own(&self, device: Device) -> Option<&Vec<Binding>> {
        match device {
            Device::KeyboardMouse => self.keyboard_mouse.as_ref(),
            Device::Gamepad => self.gamepad.as_ref(),
            Device::WiiRemote => self.wii_remote.as_ref(),
            Device::Touch => self.touch.as_ref(),
            Device::Xr(Profile::Simple) => self.xr_simple.as_ref(),
            Device::Xr(Profile::Touch) => self.xr_touch.as_ref(),
            Device::Xr(Profile::Index) => self.xr_index.as_ref(),
            Device::Xr(Profile::Vive) => self.xr_vive.as_ref(),
            Device::Xr(Profile::Hands) => self.xr_hands.as_ref(),
        }
    }

    /// The list for exactly this device, to be changed.
    pub fn own_mut(&mut self, device: Device) -> &mut Option<Vec<Binding>> {
        match device {
            Device::KeyboardMouse => &mut self.keyboard_mouse,
            Device::Gamepad => &mut self.gamepad,
            Device::WiiRemote => &mut self.wii_remote,
            Device::Touch => &mut self.touch,
            Device::Xr(Profile::Simple) => &mut self.xr_simple,
            Device::Xr(Profile::Touch) => &mut self.xr_touch,
            Device::Xr(Profile::Index) => &mut self.xr_index,
            Device::Xr(Profile::Vive) => &mut self.xr_vive,
            Device::Xr(Profile::Hands) => &mut self.xr_hands,
        }
    }

    /// All lists, by the names that files have for devices.
    pub(crate) fn lists(&self) -> impl Iterator<Item = (&'static str, &Option<Vec<Binding>>)> {
        [
            ("keyboard_mouse", &self.keyboard_mouse),
            ("gamepad", &self.gamepad),
            ("wii_remote", &self.wii_remote),
            ("touch", &self.touch),
            ("xr", &self.xr),
            ("xr_simple", &self.xr_simple),
            ("xr_touch", &self.xr_touch),
            ("xr_index", &self.xr_index),
            ("xr_vive", &self.xr_vive),
            ("xr_hands", &self.xr_hands),
        ]
        .into_iter()
    }

    /// The list that counts for a device: its own, or that of all headset controllers.
    fn of(&self, device: Device) -> Option<&Vec<Binding>> {
        match device {
            Device::Xr(_) => self.own(device).or(self.xr.as_ref()),
            _ => self.own(device),
        }
    }
}

/// Settings of the controls, as they stand in a file: what differs from the defaults.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename = "ControlsSettings")]
pub struct Bindings {
    /// Which defaults count where `bindings` say nothing: those of an object in front of you, or
    /// those of a room to walk about in.
    pub preset: Preset,
    /// Whether zooming goes the other way.
    pub invert_zoom: bool,
    /// Whether looking up and down is exchanged.
    pub invert_look: bool,
    /// Factor on all that moves, 0.05 to 20.
    pub sensitivity: Sensitivity,
    /// Actions that no device does by default: they have the inputs that `bindings` give them, and no
    /// others. Help and tables don't speak of those that have none.
    #[serde(deserialize_with = "names")]
    pub unused: Vec<String>,
    /// By the name of the action. Actions that the game adds stand here too.
    #[serde(deserialize_with = "unique")]
    pub bindings: BTreeMap<String, ActionBindings>,
}

/// A factor that is 1 by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Sensitivity(pub f32);

impl Default for Sensitivity {
    fn default() -> Self {
        Self(1.0)
    }
}

impl Bindings {
    /// What is bound to an action on a device. Inputs that a controller doesn't have are left out.
    pub fn of(&self, action: &str, device: Device) -> Vec<Binding> {
        let bound = match self.chosen(action, device) {
            Some(list) => list.clone(),
            None => self.default_of(action, device),
        };
        let has = |binding: &Binding| binding.inputs().iter().all(|input| input.is_of(device));
        bound.into_iter().filter(has).collect()
    }

    /// The list in `bindings` that counts for an action on a device: its own, or that of all headset
    /// controllers; `None` if the default counts.
    pub fn chosen(&self, action: &str, device: Device) -> Option<&Vec<Binding>> {
        self.bindings.get(action)?.of(device)
    }

    /// Whether `unused` names an action.
    pub fn is_unused(&self, action: &str) -> bool {
        self.unused.iter().any(|name| name == action)
    }

    /// What counts where `bindings` say nothing.
    fn default_of(&self, action: &str, device: Device) -> Vec<Binding> {
        if self.is_unused(action) { Vec::new() } else { defaults::of(action, device, self.preset) }
    }

    /// Binds inputs to an action on a device, whatever was bound before.
    pub fn set(&mut self, action: &str, device: Device, list: Vec<Binding>) {
        let own = self.bindings.entry(action.to_owned()).or_default();
        *own.own_mut(device) = Some(list);
    }

    /// Binds to an action on a device what is bound by default.
    pub fn restore(&mut self, action: &str, device: Device) {
        let default = self.default_of(action, device);
        let Some(own) = self.bindings.get_mut(action) else { return };
        *own.own_mut(device) = None;
        // What is set for all headsets still counts.
        if own.of(device).is_some() {
            *own.own_mut(device) = Some(default);
        }
    }

    /// The same, without what is as it would be anyway.
    pub fn without_defaults(&self) -> Self {
        let mut less = self.clone();
        less.bindings.retain(|name, own| {
            for device in Device::ALL {
                let otherwise = match (device, &own.xr) {
                    (Device::Xr(_), Some(list)) => list.clone(),
                    _ => self.default_of(name, device),
                };
                if own.own(device) == Some(&otherwise) {
                    *own.own_mut(device) = None;
                }
            }
            *own != ActionBindings::default()
        });
        less
    }

    /// The actions that an input of a device takes part in.
    pub fn uses(&self, input: Input, device: Device) -> Vec<&'static str> {
        crate::ACTIONS
            .iter()
            .filter(|info| self.of(info.name, device).iter().any(|b| b.inputs().contains(&input)))
            .map(|info| info.name)
            .collect()
    }
}
