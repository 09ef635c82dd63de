//! What is pressed, pushed or moved while an input is being chosen.

use bevy::prelude::*;
use farlight_bindings::{
    ActionInfo, ActionKind, Binding, Held, Input, Mouse, Shape, Source, Touch,
};

use super::{RebindState, RebindTarget, Rebinding};
use crate::{
    sample::Sampling,
    slots::{SLOTS, Slot},
};

/// A drag, a wheel, or a hand that is swung counts as chosen after so many of its units.
const FAR: f32 = 24.0;
/// The same for what comes in lines and doublings.
const FAR_LINES: f32 = 0.9;
/// A stick is chosen when it is pushed this far.
const PUSHED: f32 = 0.7;
/// Most inputs to hold.
const MOST_HELD: usize = 3;

/// What to ask for where there is nothing more to say.
pub(super) const PRESS: &str = "press something, or Esc to leave it as it is";

/// What to ask for first.
pub(super) fn first(kind: ActionKind) -> &'static str {
    match kind {
        ActionKind::Button => PRESS,
        ActionKind::Axis => "turn a wheel or push a trigger, or press something for less",
        ActionKind::Axis2 => "drag, or push a stick, or press something for left",
    }
}

const PAIR: [&str; 2] = ["press something for less", "press something for more"];
const FOUR: [&str; 4] = [
    "press something for left",
    "press something for right",
    "press something for down",
    "press something for up",
];

impl Rebinding {
    /// What has been chosen, once it has.
    pub(super) fn listen(
        &mut self,
        sampling: &Sampling,
        target: &RebindTarget,
        info: ActionInfo,
    ) -> Option<Result<Binding, String>> {
        let inputs = &sampling.inputs;
        let mut let_go = None;
        for slot in 0..SLOTS.len() {
            let input = SLOTS.input(slot);
            if !input.is_of(target.device) {
                continue;
            }
            match input.shape() {
                // Two numbers want a stick as a whole, all else a direction of it.
                Shape::Stick => {
                    let pushed = inputs.values[slot].length() > PUSHED;
                    if pushed && info.kind == ActionKind::Axis2 && self.parts.is_empty() {
                        return Some(self.finish(Source::One(input), info));
                    }
                }
                Shape::Delta | Shape::Delta2 => {
                    self.moved[slot] += inputs.values[slot];
                    let lines = input.shape() == Shape::Delta
                        && !matches!(input, Input::Touch(Touch::Twist));
                    let far = self.moved[slot].length() > if lines { FAR_LINES } else { FAR };
                    let whole = input != Input::Mouse(Mouse::Move);
                    if far && whole && info.kind != ActionKind::Button && self.parts.is_empty() {
                        return Some(self.finish(Source::One(input), info));
                    }
                    if far && whole && self.pressed.is_empty() {
                        let moved = Binding::new(Source::One(input));
                        return moved.fits(info.kind).err().map(|error| Err(error.to_string()));
                    }
                }
                Shape::Button | Shape::Analog => {
                    let stick = input.stick().is_some() && info.kind == ActionKind::Axis2;
                    let slot16 = slot as Slot;
                    if inputs.began(slot) && !stick && !self.pressed.contains(&slot16) {
                        self.pressed.push(slot16);
                    }
                    // What lasts for a frame, such as a tap, is let go in the next.
                    if self.pressed.contains(&slot16) && !inputs.is_down_at_all(slot) {
                        let_go = Some(slot16);
                    }
                }
            }
        }
        let_go?;
        // The last that was pressed is meant, the others were held.
        let last = SLOTS.input(usize::from(self.pressed.pop()?));
        self.hold();
        self.pressed.clear();
        self.parts.push(last);
        let prompts = match info.kind {
            ActionKind::Button => &[PRESS][..],
            ActionKind::Axis if self.parts.len() == 1 && last.shape() == Shape::Analog => {
                // A trigger goes on its own, a direction of a stick wants the other one.
                if last.stick().is_some() { &PAIR[..] } else { &[PRESS][..] }
            }
            ActionKind::Axis => &PAIR[..],
            ActionKind::Axis2 => &FOUR[..],
        };
        if let Some(next) = prompts.get(self.parts.len()) {
            if let RebindState::Waiting { prompt, refused, .. } = &mut self.state {
                (*prompt, *refused) = (next, None);
            }
            return None;
        }
        let source = match self.parts[..] {
            [one] => Source::One(one),
            [less, more] => Source::Pair([less, more]),
            [left, right, down, up] => Source::Four([left, right, down, up]),
            _ => return Some(Err("that was one too many".into())),
        };
        self.parts.clear();
        Some(self.finish(source, info))
    }

    /// What is pressed is held for what comes.
    fn hold(&mut self) {
        for slot in std::mem::take(&mut self.pressed) {
            let held = match SLOTS.input(usize::from(slot)) {
                Input::Key(key) => match key.name() {
                    "ShiftLeft" | "ShiftRight" => Held::Shift,
                    "ControlLeft" | "ControlRight" => Held::Ctrl,
                    "AltLeft" | "AltRight" => Held::Alt,
                    _ => Held::Input(Input::Key(key)),
                },
                input => Held::Input(input),
            };
            if !self.held.contains(&held) {
                self.held.push(held);
            }
        }
    }

    fn finish(&mut self, source: Source, info: ActionInfo) -> Result<Binding, String> {
        self.hold();
        let mut held = std::mem::take(&mut self.held);
        // A drag holds its own button, a trackpad that is pushed its own click, maybe.
        let own = |held: &Held| match held {
            Held::Input(input) => source.inputs().iter().any(|part| part.overlaps(*input)),
            _ => false,
        };
        held.retain(|held| !own(held));
        if held.len() > MOST_HELD {
            return Err(format!("more than {MOST_HELD} inputs to hold"));
        }
        let binding = Binding { held, ..Binding::new(source) };
        binding.fits(info.kind).map_err(|error| error.to_string())?;
        Ok(binding)
    }
}
