//! What people read instead of the names of inputs: short, for a small overlay.

use crate::{Binding, Held, Input, Key, Pad, Source, Wii, Xr};

impl Held {
    /// What people read.
    pub fn label(self) -> String {
        match self {
            Self::Input(input) => input.label(),
            other => other.to_string(),
        }
    }
}

impl Source {
    /// What people read: `W A S D`, `D-pad`, `left stick down / up`.
    pub fn label(&self) -> String {
        match self {
            Self::One(input) => input.label(),
            Self::Pair([less, more]) => match (less.stick(), more.stick()) {
                (Some((stick, less)), Some((same, more))) if stick == same => {
                    format!("{} {} / {}", stick.label(), less.label(), more.label())
                }
                _ => format!("{} / {}", less.label(), more.label()),
            },
            Self::Four([left, right, down, up]) => four([*left, *right, *down, *up]),
        }
    }
}

fn four([left, right, down, up]: [Input; 4]) -> String {
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
            [up, left, down, right].map(Input::label).join(" ")
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
    /// What people read: `Shift + W A S D`.
    pub fn label(&self) -> String {
        let mut held = self.held.clone();
        let mut source = self.source.label();
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
        let held: String = held.iter().map(|held| format!("{} + ", held.label())).collect();
        held + &source
    }
}
