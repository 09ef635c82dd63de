//! Keys, a bar to set the time, and text.

use bevy::prelude::*;
use farlight::prelude::*;

use super::{
    day::{Day, HOURS},
    panel::{self, Hud, State},
};

/// The mark on the bar.
#[derive(Component)]
pub struct Mark;

const KEYS: &str = "\
Space    stop time
,  .     earlier, later (or drag the bar)
L        lamp on, off, by itself
W A S D Q E, drag, arrows   move, look around
H        hide this
";

/// The bar's ends as fractions of the window's width, and its height in pixels above the lower edge.
const BAR: [f32; 2] = [0.15, 0.85];
const LIFT: f32 = 36.0;

/// Makes panel and bar.
pub fn spawn(mut commands: Commands) {
    panel::spawn(&mut commands, KEYS);
    let bar = |left: f32, width: f32, height: f32| Node {
        position_type: PositionType::Absolute,
        left: percent(left * 100.0),
        width: percent(width * 100.0),
        bottom: px(LIFT - height / 2.0),
        height: px(height),
        ..default()
    };
    commands.spawn((
        bar(BAR[0], BAR[1] - BAR[0], 6.0),
        BackgroundColor(Color::srgba(0.9, 0.9, 0.9, 0.5)),
    ));
    commands.spawn((Mark, bar(BAR[0], 0.008, 24.0), BackgroundColor(Color::srgb(1.0, 0.8, 0.4))));
}

/// Acts on keys.
pub fn keys(
    time: Res<Time>,
    keys: Res<ButtonInput<KeyCode>>,
    mut day: ResMut<Day>,
    mut huds: Query<&mut Visibility, Or<(With<Hud>, With<Mark>)>>,
) {
    if keys.just_pressed(KeyCode::Space) {
        day.paused = !day.paused;
    }
    if keys.just_pressed(KeyCode::KeyL) {
        day.lamp = match day.lamp {
            None => Some(true),
            Some(true) => Some(false),
            Some(false) => None,
        };
    }
    for (key, sign) in [(KeyCode::Comma, -1.0), (KeyCode::Period, 1.0)] {
        if keys.pressed(key) {
            day.paused = true;
            day.hour = (day.hour + sign * 2.0 * time.delta_secs()).clamp(HOURS[0], HOURS[1]);
        }
    }
    if keys.just_pressed(KeyCode::KeyH) {
        huds.iter_mut().for_each(|mut visibility| visibility.toggle_visible_hidden());
    }
}

/// Sets the time where the bar is pressed.
pub fn drag(
    windows: Query<&Window>,
    buttons: Res<ButtonInput<MouseButton>>,
    mut day: ResMut<Day>,
    mut held: Local<bool>,
) {
    let Ok(window) = windows.single() else { return };
    let Some(cursor) = window.cursor_position() else { return };
    let near = (window.height() - cursor.y - LIFT).abs() < 20.0;
    *held = buttons.pressed(MouseButton::Left)
        && (*held || (near && buttons.just_pressed(MouseButton::Left)));
    if *held {
        let along = (cursor.x / window.width() - BAR[0]) / (BAR[1] - BAR[0]);
        day.paused = true;
        day.hour = HOURS[0] + (HOURS[1] - HOURS[0]) * along.clamp(0.0, 1.0);
    }
}

/// Says what time it is and what is blended.
pub fn show(
    day: Res<Day>,
    status: Res<BakedStatus>,
    mut texts: Query<&mut Text, With<State>>,
    mut marks: Query<&mut Node, With<Mark>>,
) {
    let along = (day.hour - HOURS[0]) / (HOURS[1] - HOURS[0]);
    for mut mark in &mut marks {
        mark.left = percent((BAR[0] + (BAR[1] - BAR[0]) * along - 0.004) * 100.0);
    }
    let minutes = (day.hour * 60.0) as u32;
    let mut text = format!("{:02}:{:02}\n", minutes / 60, minutes % 60);
    for root in &status.roots {
        if let BakedState::Failed { reason } = &root.state {
            text += &format!("failed: {reason}\n");
        }
        for (name, weight) in &root.scenarios {
            text += &format!("{name} {weight:.2}\n");
        }
    }
    for mut shown in &mut texts {
        shown.set_if_neq(Text(text.clone()));
    }
}
