//! Where a headset's controllers put what is pressed: `farlight_xr` writes it, and so can tests.

use bevy::{platform::collections::HashMap, prelude::*};
use farlight_bindings::{Hand, Profile, Xr};

/// What is pressed on the controllers of a headset.
#[derive(Resource, Clone, Debug, Default)]
pub struct XrControllers {
    /// The left and the right one.
    pub hands: [XrHandInputs; 2],
}

/// What is pressed on one of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct XrHandInputs {
    /// Which kind of controller it is; `None` if it isn't there.
    pub profile: Option<Profile>,
    /// Buttons are 0 or 1, triggers from 0 to 1, sticks to the right and up from -1 to 1 each.
    pub values: HashMap<Xr, Vec2>,
}

impl XrControllers {
    /// One hand.
    pub fn hand(&self, hand: Hand) -> &XrHandInputs {
        &self.hands[hand as usize]
    }

    /// One hand, to be written.
    pub fn hand_mut(&mut self, hand: Hand) -> &mut XrHandInputs {
        &mut self.hands[hand as usize]
    }

    /// What an input of a hand says; zero if nothing.
    pub fn value(&self, hand: Hand, input: Xr) -> Vec2 {
        self.hand(hand).values.get(&input).copied().unwrap_or_default()
    }
}
