//! The panel with keys and state.

use bevy::prelude::*;

/// The panel.
#[derive(Component)]
pub struct Hud;

/// The text in it that changes.
#[derive(Component)]
pub struct State;

/// Makes it; `keys` say what to press.
pub fn spawn(commands: &mut Commands, keys: &str) {
    let text = |size: f32| TextFont { font_size: FontSize::Px(size), ..default() };
    let panel = Node {
        position_type: PositionType::Absolute,
        top: px(12),
        left: px(12),
        max_width: percent(60),
        padding: UiRect::all(px(10)),
        flex_direction: FlexDirection::Column,
        row_gap: px(8),
        border_radius: BorderRadius::all(px(6)),
        ..default()
    };
    commands.spawn((Hud, panel, BackgroundColor(Color::srgba(0.0, 0.0, 0.0, 0.55)))).with_children(
        |panel| {
            panel.spawn((Text::new(keys), text(13.0), TextColor(Color::srgb(0.85, 0.85, 0.82))));
            let state = TextColor(Color::srgb(1.0, 0.8, 0.45));
            panel.spawn((State, Text::default(), text(13.0), state));
        },
    );
}
