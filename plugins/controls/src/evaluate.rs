//! What bindings say: inputs of a frame become values of actions. Knows no engine's devices.

use bevy::prelude::*;
use farlight_bindings::{ActionKind, Binding, Context, Device, Profile, Shape, Source};

use crate::{
    compile::Compiled,
    inputs::{HYSTERESIS, Inputs, PRESSED},
};

/// Longest time that counts for what is held, in seconds: a frame that took longer was a hitch, and
/// nobody wants to have walked through it.
pub(crate) const LONGEST_FRAME: f32 = 0.1;

/// What a binding remembers from frame to frame.
#[derive(Clone, Copy, Debug, Default)]
struct Memory {
    /// As a button it is down.
    pressed: bool,
    /// Its inputs did something else, or nothing; it waits until they are let go.
    silent: bool,
}

/// The bindings in force, and what they remember.
#[derive(Clone, Debug, Default)]
pub(crate) struct Evaluator {
    bindings: Vec<Compiled>,
    memory: Vec<Memory>,
    /// All that a binding wants held is.
    armed: Vec<bool>,
}

/// What is true of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// Its length in seconds.
    pub(crate) seconds: f32,
    /// Whether actions of panels are heard, and take their inputs from others.
    pub(crate) panel: bool,
    /// Nobody is heard: an input is being chosen.
    pub(crate) mute: bool,
    /// Controllers of a headset.
    pub(crate) profile: Option<Profile>,
}

impl Evaluator {
    pub(crate) fn bindings(&self) -> &[Compiled] {
        &self.bindings
    }

    /// Other bindings are in force. What goes on being bound goes on being held; what is new and already
    /// down waits until it is let go.
    pub(crate) fn replace(&mut self, bindings: Vec<Compiled>) {
        let memory = bindings.iter().map(|new| {
            let old = self.bindings.iter().position(|old| old.is_same(new));
            // If it is not down, the next frame forgets that it is silent.
            old.map_or(Memory { silent: true, pressed: false }, |old| self.memory[old])
        });
        self.memory = memory.collect();
        self.armed = vec![false; bindings.len()];
        self.bindings = bindings;
    }

    /// Writes what each action says.
    pub(crate) fn evaluate(&mut self, inputs: &Inputs, frame: Frame, said: &mut [Vec2]) {
        said.fill(Vec2::ZERO);
        for (armed, binding) in self.armed.iter_mut().zip(&self.bindings) {
            let down = |slot: &u16| inputs.is_down(*slot, binding.context);
            *armed = binding.is_of(frame.profile)
                && (binding.context != Context::Panel || frame.panel)
                && binding.held.iter().all(|any| any.iter().any(down));
        }
        for (at, binding) in self.bindings.iter().enumerate() {
            if !binding.is_of(frame.profile) {
                self.memory[at] = Memory::default();
                continue;
            }
            let memory = &mut self.memory[at];
            let masked = binding.masks.iter().any(|mask| self.armed[usize::from(*mask)])
                || (binding.in_panel && frame.panel)
                || frame.mute;
            let unheard = binding.context == Context::Panel && !frame.panel;
            // A button counts only if it is pressed while the others are held; a stick that is already
            // pushed may go over to another action.
            let early = binding.kind == ActionKind::Button && !self.armed[at];
            let active = binding.is_active(inputs);
            memory.silent = active && (memory.silent || masked || unheard || early);
            if memory.silent || masked || !self.armed[at] {
                memory.pressed = false;
                continue;
            }
            let value = match binding.kind {
                ActionKind::Button => {
                    memory.pressed = binding.pressed(inputs, memory.pressed);
                    Vec2::new(f32::from(u8::from(memory.pressed)), 0.0)
                }
                _ => binding.moved(inputs, frame.seconds),
            };
            let said = &mut said[usize::from(binding.action)];
            if value != Vec2::ZERO && value.is_finite() {
                match binding.kind {
                    ActionKind::Button => *said = value,
                    _ => *said += value,
                }
            }
        }
    }
}

impl Compiled {
    /// Whether its device is there; controllers of a headset are of one kind.
    fn is_of(&self, profile: Option<Profile>) -> bool {
        match self.device {
            Device::Xr(own) => profile == Some(own),
            _ => true,
        }
    }

    /// From where on it is down, as a button.
    fn threshold(&self) -> f32 {
        if self.binding.dead_zone > 0.0 { self.binding.dead_zone } else { PRESSED }
    }

    /// Whether its inputs are being used, by whomever.
    fn is_active(&self, inputs: &Inputs) -> bool {
        let rest = match self.kind {
            ActionKind::Button => self.threshold() * HYSTERESIS,
            _ => self.binding.dead_zone.max(0.1),
        };
        self.source.iter().any(|slot| match inputs.button_of_drag(*slot) {
            Some(button) => inputs.is_down_at_all(usize::from(button)),
            // What is moved is moved anew in every frame.
            None => self.rate && inputs.values[usize::from(*slot)].length() > rest,
        })
    }

    fn pressed(&self, inputs: &Inputs, before: bool) -> bool {
        let threshold = self.threshold() * if before { HYSTERESIS } else { 1.0 };
        let value = |slot: &u16| inputs.value(*slot, self.context).x;
        self.source.iter().any(|slot| value(slot) >= threshold)
    }

    /// What was moved, in the action's unit.
    fn moved(&self, inputs: &Inputs, seconds: f32) -> Vec2 {
        let value = |slot: u16| inputs.value(slot, self.context);
        let bent = |slot: u16| bend(&self.binding, value(slot).x);
        let raw = match (self.binding.source, &self.source[..]) {
            (Source::One(input), &[slot]) => match input.shape() {
                Shape::Stick => stick(&self.binding, value(slot)),
                Shape::Analog | Shape::Button => Vec2::new(bent(slot), 0.0),
                Shape::Delta | Shape::Delta2 => value(slot),
            },
            (_, &[less, more]) => Vec2::new(bent(more) - bent(less), 0.0),
            (_, &[left, right, down, up]) => {
                // Two keys at once are no faster than one.
                Vec2::new(bent(right) - bent(left), bent(up) - bent(down)).clamp_length_max(1.0)
            }
            _ => Vec2::ZERO,
        };
        let time = if self.rate { seconds.min(LONGEST_FRAME) } else { 1.0 };
        let raw = if self.kind == ActionKind::Axis { raw.with_y(0.0) } else { raw };
        raw * Vec2::from(self.factors) * time
    }
}

/// Dead zone and curve of a value from 0 to 1.
pub(crate) fn bend(binding: &Binding, value: f32) -> f32 {
    let zone = binding.dead_zone;
    if value <= zone {
        return 0.0;
    }
    ((value - zone) / (1.0 - zone)).clamp(0.0, 1.0).powf(binding.curve)
}

/// Dead zone and curve of a stick, by how far it is pushed; where to stays as it is.
pub(crate) fn stick(binding: &Binding, value: Vec2) -> Vec2 {
    let pushed = value.length();
    if pushed > 0.0 { value / pushed * bend(binding, pushed) } else { Vec2::ZERO }
}
