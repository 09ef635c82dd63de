//! Bindings, made ready to be asked in every frame.

use farlight_bindings::{
    ActionInfo, ActionKind, Binding, Bindings, Context, Device, Held, Input, Profile, Shape,
};

use crate::slots::{SLOTS, Slot};

/// A binding that is asked in every frame.
#[derive(Clone, Debug)]
pub(crate) struct Compiled {
    /// Place of its action.
    pub(crate) action: u16,
    pub(crate) name: &'static str,
    pub(crate) device: Device,
    pub(crate) context: Context,
    pub(crate) kind: ActionKind,
    pub(crate) binding: Binding,
    /// Places of its inputs: one, less and more, or left, right, down and up.
    pub(crate) source: Vec<Slot>,
    /// Of each of these groups one must be down.
    pub(crate) held: Vec<Vec<Slot>>,
    /// Bindings that silence this one while all that they want held is held.
    pub(crate) masks: Vec<u16>,
    /// Whether an open panel uses an input of it.
    pub(crate) in_panel: bool,
    /// Whether it gives so much a second, not so much an input's unit.
    pub(crate) rate: bool,
    /// Factors on x and y: scale, inversion, sensitivity.
    pub(crate) factors: [f32; 2],
}

impl Compiled {
    /// Whether this is the same binding, whatever else has changed.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.action == other.action
            && self.device == other.device
            && self.source == other.source
            && self.held == other.held
    }
}

/// All bindings of all devices.
pub(crate) fn compile(bindings: &Bindings, actions: &[ActionInfo]) -> Vec<Compiled> {
    let mut all = Vec::new();
    for device in Device::ALL {
        let first = all.len();
        for (action, info) in actions.iter().enumerate() {
            for binding in bindings.of(info.name, device) {
                // What doesn't fit is one of the problems that are told; it does nothing.
                if binding.fits(info.kind).is_ok() {
                    all.push(one(action as u16, info, device, binding, bindings));
                }
            }
        }
        relate(&mut all[first..], first);
    }
    all
}

fn one(
    action: u16,
    info: &ActionInfo,
    device: Device,
    binding: Binding,
    settings: &Bindings,
) -> Compiled {
    let inputs = binding.source.inputs();
    let moves = |input: &Input| matches!(input.shape(), Shape::Delta | Shape::Delta2);
    let held = binding
        .held
        .iter()
        .map(|held: &Held| held.inputs().iter().map(|input| SLOTS.of(*input)).collect::<Vec<_>>());
    let sign = |inverted: bool| if inverted { -1.0 } else { 1.0 };
    let mut factors = [sign(binding.invert_x), sign(binding.invert_y)];
    if info.name == "zoom" {
        factors[0] *= sign(settings.invert_zoom);
    }
    if info.name == "orbit" {
        factors[1] *= sign(settings.invert_look);
    }
    let scale = binding.scale * settings.sensitivity.0;
    Compiled {
        action,
        name: info.name,
        device,
        context: info.context,
        kind: info.kind,
        source: inputs.iter().map(|input| SLOTS.of(*input)).collect(),
        held: held.collect(),
        masks: Vec::new(),
        in_panel: false,
        rate: !inputs.iter().any(moves),
        factors: factors.map(|factor| factor * scale),
        binding,
    }
}

/// Finds out who silences whom. `first` is the place of the first of them among all.
fn relate(of_device: &mut [Compiled], first: usize) {
    let panel = |compiled: &Compiled| compiled.context == Context::Panel;
    for at in 0..of_device.len() {
        let this = &of_device[at];
        let masks = of_device.iter().enumerate().filter(|(_, other)| {
            panel(this) == panel(other) && this.binding.is_masked_by(&other.binding)
        });
        let masks = masks.map(|(other, _)| (first + other) as u16).collect();
        let in_panel = !panel(this)
            && of_device
                .iter()
                .any(|other| panel(other) && other.binding.takes_from(&this.binding));
        of_device[at].masks = masks;
        of_device[at].in_panel = in_panel;
    }
}

/// The inputs with which hands press what a panel shows.
pub(crate) fn presses(all: &[Compiled], profile: Option<Profile>) -> Vec<Slot> {
    let profile = profile.map(Device::Xr);
    let pressing = all
        .iter()
        .filter(|compiled| compiled.name == "panel_press" && Some(compiled.device) == profile);
    pressing.flat_map(|compiled| compiled.source.iter().copied()).collect()
}
