//! What inputs say in this frame, whose they are, and which are dead until they are let go.

use bevy::prelude::*;
use farlight_bindings::{Context, Input, Key, Mouse};

use crate::{
    InputCapture,
    slots::{Bases, SLOTS, Slot},
};

/// A trigger is down from here on.
pub(crate) const PRESSED: f32 = 0.5;
/// What was down at a threshold is up below this part of it: a trembling finger presses once.
pub(crate) const HYSTERESIS: f32 = 0.8;

/// Below this a trigger was let go.
const REST: f32 = 0.1;

/// All inputs of a frame.
#[derive(Clone, Debug)]
pub(crate) struct Inputs {
    /// What they say.
    pub(crate) values: Vec<Vec2>,
    /// Whether they are down as buttons.
    down: Vec<bool>,
    /// Whether they were, a frame before.
    before: Vec<bool>,
    /// They belong to a panel until they are let go: only actions of panels hear them.
    taken: Vec<bool>,
    /// Nobody hears them until they are let go.
    dead: Vec<bool>,
    /// How each is treated.
    kinds: Vec<Kind>,
}

/// What of [`InputCapture`] concerns an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A key that writes.
    Letter,
    /// Where it is pressed decides.
    MouseButton,
    /// Follows its button.
    Drag(Slot),
    /// Where the pointer is decides.
    Pointer,
    /// Of this hand.
    Hand(usize),
    Free,
}

impl Default for Inputs {
    fn default() -> Self {
        let bases = Bases::get();
        let button = |mouse: Mouse| bases.mouse(mouse) as Slot;
        let kinds = (0..SLOTS.len()).map(|slot| match SLOTS.input(slot) {
            Input::Key(key) if writes(key) => Kind::Letter,
            Input::Mouse(Mouse::LeftDrag) => Kind::Drag(button(Mouse::Left)),
            Input::Mouse(Mouse::RightDrag) => Kind::Drag(button(Mouse::Right)),
            Input::Mouse(Mouse::MiddleDrag) => Kind::Drag(button(Mouse::Middle)),
            Input::Mouse(Mouse::Move | Mouse::Wheel) => Kind::Pointer,
            Input::Mouse(_) => Kind::MouseButton,
            Input::Xr(hand, _) => Kind::Hand(hand as usize),
            // Fingers belong to a panel or to the scene one by one: gestures know.
            _ => Kind::Free,
        });
        let kinds: Vec<_> = kinds.collect();
        let none = vec![false; kinds.len()];
        Self {
            values: vec![Vec2::ZERO; kinds.len()],
            down: none.clone(),
            before: none.clone(),
            taken: none.clone(),
            dead: none,
            kinds,
        }
    }
}

/// Whether a key belongs to a text that is being written.
fn writes(key: Key) -> bool {
    let name = key.name();
    let function = name.starts_with('F') && name[1..].parse::<u8>().is_ok();
    !(function || name == "Escape")
}

impl Inputs {
    /// Begins a frame: nothing says anything.
    pub(crate) fn clear(&mut self) {
        self.values.fill(Vec2::ZERO);
    }

    /// Ends the reading of devices: what is down, and whose it is. `presses` are the inputs with which
    /// hands press what a panel shows; `lost` says that the window has lost the focus.
    pub(crate) fn settle(&mut self, capture: &InputCapture, presses: &[Slot], lost: bool) {
        for (slot, stick, direction) in &SLOTS.directions {
            let stick = self.values[usize::from(*stick)];
            self.values[usize::from(*slot)].x = direction.of(stick.to_array());
        }
        std::mem::swap(&mut self.down, &mut self.before);
        for slot in 0..self.values.len() {
            let threshold = if self.before[slot] { PRESSED * HYSTERESIS } else { PRESSED };
            self.down[slot] = self.values[slot].x.abs() >= threshold;
            if self.values[slot].length_squared() < REST * REST {
                self.taken[slot] = false;
                self.dead[slot] = false;
            }
            let began = self.down[slot] && !self.before[slot];
            match self.kinds[slot] {
                Kind::Letter => {
                    self.dead[slot] |= self.down[slot] && (capture.keyboard || lost);
                }
                Kind::MouseButton => {
                    self.taken[slot] |= began && capture.pointer;
                    self.dead[slot] |= self.down[slot] && lost;
                }
                // Buttons come before drags.
                Kind::Drag(button) => {
                    self.taken[slot] = self.taken[usize::from(button)];
                    self.dead[slot] = self.dead[usize::from(button)];
                }
                Kind::Pointer => self.taken[slot] = capture.pointer,
                Kind::Hand(hand) => {
                    let press = presses.contains(&(slot as Slot));
                    self.taken[slot] |= began && press && capture.hands[hand];
                }
                Kind::Free => {}
            }
        }
    }

    /// What an input says to actions of a context.
    pub(crate) fn value(&self, slot: Slot, context: Context) -> Vec2 {
        if self.is_heard(slot, context) { self.values[usize::from(slot)] } else { Vec2::ZERO }
    }

    /// Whether it is down for actions of a context.
    pub(crate) fn is_down(&self, slot: Slot, context: Context) -> bool {
        self.down[usize::from(slot)] && self.is_heard(slot, context)
    }

    /// Whether it was pressed in this frame, whoever hears it.
    pub(crate) fn began(&self, slot: usize) -> bool {
        self.down[slot] && !self.before[slot]
    }

    /// Whether it is down, whoever hears it.
    pub(crate) fn is_down_at_all(&self, slot: usize) -> bool {
        self.down[slot]
    }

    /// The button that a drag needs.
    pub(crate) fn button_of_drag(&self, slot: Slot) -> Option<Slot> {
        match self.kinds[usize::from(slot)] {
            Kind::Drag(button) => Some(button),
            _ => None,
        }
    }

    fn is_heard(&self, slot: Slot, context: Context) -> bool {
        let slot = usize::from(slot);
        !self.dead[slot] && (context == Context::Panel || !self.taken[slot])
    }
}
