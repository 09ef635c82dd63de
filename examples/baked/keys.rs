//! Keys, and what is on screen about them.

use bevy::{camera::Exposure, prelude::*};
use farlight::prelude::*;

use super::panel::{self, Hud, State};

const KEYS: &str = "\
1 to 8   scenario
W A S D Q E, drag, arrows   move, look around
+  -     exposure
B        bicubic filtering
H        hide this
";

const DIGITS: [KeyCode; 8] = [
    KeyCode::Digit1,
    KeyCode::Digit2,
    KeyCode::Digit3,
    KeyCode::Digit4,
    KeyCode::Digit5,
    KeyCode::Digit6,
    KeyCode::Digit7,
    KeyCode::Digit8,
];

/// Makes the panel.
pub fn spawn(mut commands: Commands) {
    panel::spawn(&mut commands, KEYS);
}

/// Acts on keys.
pub fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    status: Res<BakedStatus>,
    mut lighting: Query<&mut BakedLighting>,
    mut exposures: Query<&mut Exposure>,
    mut huds: Query<&mut Visibility, With<Hud>>,
) {
    for (index, key) in DIGITS.into_iter().enumerate() {
        let scenario = status.roots.first().and_then(|root| root.scenarios.get(index));
        if let (true, Some((name, _))) = (keys.just_pressed(key), scenario) {
            lighting.iter_mut().for_each(|mut l| l.scenarios.show(name.clone()));
        }
    }
    if keys.just_pressed(KeyCode::KeyB) {
        lighting.iter_mut().for_each(|mut l| l.bicubic = !l.bicubic);
    }
    let brighter = keys.any_just_pressed([KeyCode::Equal, KeyCode::NumpadAdd]);
    let darker = keys.any_just_pressed([KeyCode::Minus, KeyCode::NumpadSubtract]);
    let step = f32::from(u8::from(darker)) - f32::from(u8::from(brighter));
    if step != 0.0 {
        exposures.iter_mut().for_each(|mut exposure| exposure.ev100 += step * 0.5);
    }
    if keys.just_pressed(KeyCode::KeyH) {
        huds.iter_mut().for_each(|mut visibility| visibility.toggle_visible_hidden());
    }
}

/// Says what is shown.
pub fn show(
    status: Res<BakedStatus>,
    exposures: Query<&Exposure>,
    mut texts: Query<&mut Text, With<State>>,
) {
    let Some(root) = status.roots.first() else { return };
    let state = match &root.state {
        BakedState::Loading => "loading".into(),
        BakedState::Lit => format!("{} meshes lit", root.receivers),
        BakedState::Failed { reason } => format!("failed: {reason}"),
    };
    let ev100 = exposures.iter().next().map_or(0.0, |exposure| exposure.ev100);
    let mut text = format!("{state}, {} left out, EV100 {ev100}\n", root.left_out.len());
    for (index, (name, weight)) in root.scenarios.iter().enumerate() {
        text += &format!("{} {name}: {weight}\n", index + 1);
    }
    for mut shown in &mut texts {
        shown.set_if_neq(Text(text.clone()));
    }
}
