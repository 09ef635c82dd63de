//! Every input has a place in one array.

use std::sync::LazyLock;

use bevy::{platform::collections::HashMap, prelude::*};
use farlight_bindings::{Direction, Hand, Input, Key, Mouse, Pad, Touch, Wii, Xr};

/// A place in [`Slots`].
pub(crate) type Slot = u16;

/// The places of inputs, in the order of [`Input::all`].
pub(crate) struct Slots {
    inputs: Vec<Input>,
    of: HashMap<Input, Slot>,
    keys: HashMap<KeyCode, Slot>,
    /// A direction of a stick: its place, the stick's, which.
    pub(crate) directions: Vec<(Slot, Slot, Direction)>,
}

/// The one table.
pub(crate) static SLOTS: LazyLock<Slots> = LazyLock::new(|| {
    let inputs: Vec<Input> = Input::all().collect();
    let of: HashMap<_, _> = inputs.iter().enumerate().map(|(at, i)| (*i, at as Slot)).collect();
    let keys = Key::all().filter_map(|key| Some((key_code(key)?, of[&Input::Key(key)]))).collect();
    let direction = |input: &Input| {
        let (stick, direction) = input.stick()?;
        Some((of[input], of[&stick], direction))
    };
    let directions = inputs.iter().filter_map(direction).collect();
    Slots { inputs, of, keys, directions }
});

/// Where the first input of each kind is. Kinds lie one after another, in the order of their `ALL`.
pub(crate) struct Bases {
    pub(crate) mouse: usize,
    pub(crate) pad: usize,
    pub(crate) wii: usize,
    pub(crate) touch: usize,
    pub(crate) hands: [usize; 2],
}

impl Bases {
    /// The places of all kinds.
    pub(crate) fn get() -> Self {
        let mouse = farlight_bindings::KEYS.len();
        let pad = mouse + Mouse::ALL.len();
        let wii = pad + Pad::ALL.len();
        let touch = wii + Wii::ALL.len();
        let left = touch + Touch::ALL.len();
        let right = left + Xr::ALL.len();
        Self { mouse, pad, wii, touch, hands: [left, right] }
    }

    /// The place of an input of the mouse.
    pub(crate) fn mouse(&self, mouse: Mouse) -> usize {
        self.mouse + mouse as usize
    }

    /// The place of an input of a gamepad.
    pub(crate) fn pad(&self, pad: Pad) -> usize {
        self.pad + pad as usize
    }

    /// The place of an input of a Wii Remote.
    pub(crate) fn wii(&self, wii: Wii) -> usize {
        self.wii + wii as usize
    }

    /// The place of a gesture.
    pub(crate) fn touch(&self, touch: Touch) -> usize {
        self.touch + touch as usize
    }

    /// The place of an input of a hand.
    pub(crate) fn hand(&self, hand: Hand, xr: Xr) -> usize {
        self.hands[hand as usize] + xr as usize
    }
}

impl Slots {
    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.inputs.len()
    }

    /// The place of an input.
    pub(crate) fn of(&self, input: Input) -> Slot {
        self.of[&input]
    }

    /// The input at a place.
    pub(crate) fn input(&self, slot: usize) -> Input {
        self.inputs[slot]
    }

    /// The place of one of Bevy's keys.
    pub(crate) fn key(&self, code: KeyCode) -> Option<usize> {
        self.keys.get(&code).map(|slot| usize::from(*slot))
    }
}

/// Bevy's name of a key.
fn key_code(key: Key) -> Option<KeyCode> {
    use bevy::reflect::{
        PartialReflect as _,
        enums::{DynamicEnum, DynamicVariant},
    };
    let mut code = KeyCode::KeyA;
    code.try_apply(&DynamicEnum::new(key.name(), DynamicVariant::Unit)).ok()?;
    Some(code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_the_names() {
        let bases = Bases::get();
        assert_eq!(bases.hands[1] + Xr::ALL.len(), SLOTS.len());
        assert_eq!(SLOTS.input(bases.mouse(Mouse::Wheel)), Input::Mouse(Mouse::Wheel));
        assert_eq!(SLOTS.input(bases.pad(Pad::Mode)), Input::Pad(Pad::Mode));
        assert_eq!(SLOTS.input(bases.wii(Wii::Down)), Input::Wii(Wii::Down));
        for hand in Hand::ALL {
            for xr in Xr::ALL {
                assert_eq!(SLOTS.input(bases.hand(hand, *xr)), Input::Xr(hand, *xr));
            }
        }
    }

    #[test]
    fn every_key_is_one_of_bevy() {
        for key in Key::all() {
            assert!(key_code(key).is_some(), "{}", key.name());
        }
    }
}
