//! What is bound when nobody says otherwise. The keys are those of Schiller, *BTF Rendering in
//! Virtual Reality*, 2022, appendix A, where it names one.
//!
//! No gamepad or controller needs two buttons at once for what people do often, and both hands do
//! half of the work: what the users of that application asked for (section 8.1.3). What is done
//! seldom lies one layer below: a shoulder or a trigger is held, and the other inputs do something
//! else.

mod desktop;
mod headset;

use std::{collections::HashMap, sync::OnceLock};

use serde::{Deserialize, Serialize};

use crate::{ActionKind, Binding, Device, Profile, Shape, Source, action};

/// Which defaults count where a file says nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Preset {
    /// An object in front of you: sticks go round it and turn it.
    #[default]
    Viewer,
    /// A room that you walk about in: sticks walk and look; in a headset the left one teleports and
    /// turns you by steps.
    Room,
}

impl Preset {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Viewer, Self::Room];
}

/// Action, input, scale.
type Row = (&'static str, &'static str, f32);

/// What a device has in both presets, and what the room has instead: all of an action, nothing if
/// the input is empty.
struct Table {
    rows: &'static [Row],
    room: &'static [Row],
}

fn table(device: Device) -> Table {
    match device {
        Device::KeyboardMouse => desktop::KEYBOARD_MOUSE,
        Device::Gamepad => desktop::GAMEPAD,
        Device::WiiRemote => desktop::WII_REMOTE,
        Device::Touch => desktop::TOUCH,
        Device::Xr(Profile::Touch | Profile::Index) => headset::STICKS,
        Device::Xr(Profile::Vive) => headset::VIVE,
        Device::Xr(Profile::Simple) => headset::SIMPLE,
        Device::Xr(Profile::Hands) => headset::HANDS,
    }
}

/// What is bound to an action by default.
pub(crate) fn of(name: &str, device: Device, preset: Preset) -> Vec<Binding> {
    // Texts are read once: help may be asked for in every frame.
    static ALL: OnceLock<HashMap<(Device, Preset), Vec<(&str, Binding)>>> = OnceLock::new();
    let all = ALL.get_or_init(|| {
        let devices = Device::ALL.into_iter();
        let keys = devices.flat_map(|device| Preset::ALL.map(|preset| (device, preset)));
        keys.map(|key| (key, read(key.0, key.1))).collect()
    });
    let list = all.get(&(device, preset)).map(Vec::as_slice).unwrap_or_default();
    list.iter().filter(|(own, _)| *own == name).map(|(_, binding)| binding.clone()).collect()
}

/// All that is bound on a device.
fn read(device: Device, preset: Preset) -> Vec<(&'static str, Binding)> {
    let Table { rows, room } = table(device);
    let room = if preset == Preset::Room { room } else { &[] };
    let replaced = |row: &&Row| !room.iter().any(|other| other.0 == row.0);
    let rows = rows.iter().filter(replaced).chain(room).filter(|row| !row.1.is_empty());
    rows.filter_map(|&(name, input, scale)| {
        let binding = Binding { scale, ..input.parse().ok()? };
        // One table serves Touch and Index; the latter has no menu button.
        if !binding.inputs().iter().all(|input| input.is_of(device)) {
            return None;
        }
        let moves = action(name)?.kind != ActionKind::Button;
        Some((name, if moves { finer(binding) } else { binding }))
    })
    .collect()
}

/// Small moves of what has a way to go are finer.
fn finer(binding: Binding) -> Binding {
    let inputs = binding.source.inputs();
    let stick = matches!(binding.source, Source::One(input) if input.shape() == Shape::Stick);
    let analog = inputs.iter().all(|input| input.shape() == Shape::Analog);
    match stick || analog {
        true if binding.dead_zone == 0.0 => Binding { curve: 2.0, dead_zone: 0.05, ..binding },
        true => Binding { curve: 2.0, ..binding },
        false => binding,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_binds_something() {
        for device in Device::ALL {
            let Table { rows, room } = table(device);
            for &(name, input, scale) in rows.iter().chain(room) {
                assert!(action(name).is_some(), "{device}: {name}");
                if input.is_empty() {
                    continue;
                }
                let binding: Binding = input.parse().unwrap_or_else(|e| panic!("{device}: {e}"));
                assert!(scale > 0.0 && binding.input_text() == input, "{device}: {input}");
                // One table serves Touch and Index; the latter has no menu button.
                let has = binding.inputs().iter().all(|input| input.is_of(device));
                assert!(has || input == "Left.Menu", "{device}: {input}");
            }
        }
    }
}
