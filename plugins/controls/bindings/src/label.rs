//! What people read instead of the names of inputs: short, for a small overlay.

use crate::{Binding, Device, Hand, Held, Input, Key, Pad, Profile, Source, Wii, Xr};

impl Input {
    /// What people read who have this device in hand: `right A` instead of `right lower button (A, X)`.
    pub fn label_on(self, device: Device) -> String {
        let letters = match (self, device) {
            (Self::Xr(Hand::Left, _), Device::Xr(Profile::Touch)) => ["left X", "left Y"],
            (Self::Xr(Hand::Left, _), Device::Xr(Profile::Index)) => ["left A", "left B"],
            (Self::Xr(..), Device::Xr(Profile::Touch | Profile::Index)) => ["right A", "right B"],
            _ => return self.label(),
        };
        match self {
            Self::Xr(_, Xr::Primary) => letters[0].into(),
            Self::Xr(_, Xr::Secondary) => letters[1].into(),
            _ => self.label(),
        }
    }
}

impl Held {
    /// What people read who have this device in hand.
    pub fn label_on(self, device: Device) -> String {
        match self {
            Self::Input(input) => input.label_on(device),
            other => other.to_string(),
        }
    }
}

impl Source {
    /// What people read: `W A S D`, `D-pad`, `left stick down / up`.
    pub fn label_on(&self, device: Device) -> String {
        match self {
            Self::One(input) => input.label_on(device),
            Self::Pair([less, more]) => match (less.stick(), more.stick()) {
                (Some((stick, less)), Some((same, more))) if stick == same => {
                    format!("{} {} / {}", stick.label(), less.label(), more.label())
                }
                _ => format!("{} / {}", less.label_on(device), more.label_on(device)),
            },
            Self::Four([left, right, down, up]) => four([*left, *right, *down, *up], device),
        }
    }
}

fn four([left, right, down, up]: [Input; 4], device: Device) -> String {
    match [left, right, down, up] {
        [
            Input::Pad(Pad::DPadLeft),
            Input::Pad(Pad::DPadRight),
            Input::Pad(Pad::DPadDown),
            Input::Pad(Pad::DPadUp),
        ] => "D-pad".into(),
        [
            Input::Wii(Wii::Left),
            Input::Wii(Wii::Right),
            Input::Wii(Wii::Down),
            Input::Wii(Wii::Up),
        ] => "cross".into(),
        inputs => {
            let arrows = ["ArrowLeft", "ArrowRight", "ArrowDown", "ArrowUp"];
            if arrows.map(Key::named) == inputs.map(key) {
                return "arrows".into();
            }
            // As they lie on a keyboard.
            [up, left, down, right].map(|input| input.label_on(device)).join(" ")
        }
    }
}

fn key(input: Input) -> Option<Key> {
    match input {
        Input::Key(key) => Some(key),
        _ => None,
    }
}

impl Binding {
    /// What people read who have this device in hand: `Shift + W A S D`.
    pub fn label_on(&self, device: Device) -> String {
        let mut held = self.held.clone();
        let mut source = self.source.label_on(device);
        // To press a trackpad somewhere is one thing to do.
        let pressed = held.iter().position(|held| match (held, self.source.inputs()[0]) {
            (Held::Input(Input::Xr(hand, Xr::TrackpadClick)), input @ Input::Xr(on, xr)) => {
                let pad = input
                    .stick()
                    .map_or(xr == Xr::Trackpad, |(pad, _)| pad == Input::Xr(on, Xr::Trackpad));
                *hand == on && pad
            }
            _ => false,
        });
        if let Some(at) = pressed {
            held.remove(at);
            source = format!("press {source}");
        }
        let held: String =
            held.iter().map(|held| format!("{} + ", held.label_on(device))).collect();
        held + &source
    }
}
