//! All actions with their inputs for the device in hand; what is used lights up.

use bevy::prelude::*;
use farlight::controls::{ActionPerformed, ActionValues, ActiveDevice, ControlsInForce};
use farlight_bindings::{ACTIONS, ActionInfo, Context, first_hint};

/// Seconds for which a row is alight after it was used.
const AFTERGLOW: f32 = 0.7;
const TEXT: Color = Color::srgb(0.90, 0.91, 0.93);
const DIM: Color = Color::srgb(0.79, 0.81, 0.85);
const LIT: Color = Color::srgb(1.0, 0.75, 0.34);
/// Behind rows: what is behind it changes little, so that a white object leaves every text a contrast of
/// 4.5 and more (WCAG 2, AA).
const BEHIND: Color = Color::srgba(0.03, 0.035, 0.045, 0.96);
/// How much a row that is used is tinted; the bar at its edge says it louder, and no text is on it.
const TINT: f32 = 0.07;

/// The columns that hold rows.
#[derive(Component)]
pub struct Column(usize);

/// The device's name.
#[derive(Component)]
pub struct Title;

/// How to get at menu and help.
#[derive(Component)]
pub struct Hint;

/// A row.
#[derive(Component)]
pub struct Row {
    action: &'static ActionInfo,
    /// Seconds for which it is still alight.
    glow: f32,
}

/// Its number.
#[derive(Component)]
pub struct Says(&'static str);

/// Makes title and columns.
pub fn spawn(mut commands: Commands) {
    let column = |side: usize| {
        let edge = px(14);
        let (left, right) = if side == 0 { (edge, Val::Auto) } else { (Val::Auto, edge) };
        let node = Node {
            position_type: PositionType::Absolute,
            top: px(14),
            left,
            right,
            width: px(410),
            padding: UiRect::axes(px(8), px(8)),
            flex_direction: FlexDirection::Column,
            border_radius: BorderRadius::all(px(8)),
            ..default()
        };
        (Column(side), node, BackgroundColor(BEHIND))
    };
    commands.spawn(column(0));
    commands.spawn(column(1));
    let across = |top, bottom| Node {
        position_type: PositionType::Absolute,
        top,
        bottom,
        width: percent(100),
        justify_content: JustifyContent::Center,
        ..default()
    };
    commands.spawn(across(px(20), Val::Auto)).with_children(|parent| {
        parent.spawn((Title, Text::default(), font(22.0), TextColor(Color::WHITE)));
    });
    commands.spawn(across(Val::Auto, px(20))).with_children(|parent| {
        parent.spawn((Hint, Text::default(), font(16.0), TextColor(TEXT)));
    });
}

fn font(size: f32) -> TextFont {
    TextFont { font_size: FontSize::Px(size), ..default() }
}

/// Writes the rows anew when another device is in hand or bindings have changed.
pub fn fill(
    device: Res<ActiveDevice>,
    in_force: Res<ControlsInForce>,
    columns: Query<(Entity, &Column)>,
    mut title: Single<&mut Text, (With<Title>, Without<Hint>)>,
    mut hint: Single<&mut Text, (With<Hint>, Without<Title>)>,
    mut commands: Commands,
) {
    if !device.is_changed() && !in_force.is_changed() {
        return;
    }
    title.0 = match &device.name {
        Some(name) => format!("{}: {name}", device.device),
        None => device.device.to_string(),
    };
    let bindings = &in_force.bindings;
    hint.0 = first_hint(bindings, device.device);
    let rows: Vec<_> = ACTIONS
        .iter()
        .filter(|action| action.context != Context::Panel)
        .filter_map(|action| {
            let bound = bindings.of(action.name, device.device);
            let labels: Vec<_> =
                bound.iter().map(|binding| binding.label_on(device.device)).collect();
            (!labels.is_empty()).then(|| (action, labels.join(", ")))
        })
        .collect();
    let half = rows.len().div_ceil(2);
    for (column, Column(side)) in &columns {
        commands.entity(column).despawn_children().with_children(|parent| {
            for (action, inputs) in rows.iter().skip(side * half).take(half) {
                row(parent, action, inputs);
            }
        });
    }
}

fn row(parent: &mut ChildSpawnerCommands, action: &'static ActionInfo, inputs: &str) {
    let node = Node {
        width: percent(100),
        padding: UiRect::axes(px(6), px(2)),
        border: UiRect::left(px(4)),
        column_gap: px(10),
        justify_content: JustifyContent::SpaceBetween,
        align_items: AlignItems::Center,
        border_radius: BorderRadius::all(px(4)),
        ..default()
    };
    let bar = BorderColor::all(Color::NONE);
    let row = (Row { action, glow: 0.0 }, node, BackgroundColor(Color::NONE), bar);
    parent.spawn(row).with_children(|row| {
        row.spawn((Text::new(action.label), font(12.5), TextColor(TEXT)));
        row.spawn(Node { column_gap: px(8), align_items: AlignItems::Center, ..default() })
            .with_children(|right| {
                right.spawn((Says(action.name), Text::default(), font(11.5), TextColor(LIT)));
                let layout = TextLayout { justify: Justify::Right, ..default() };
                right.spawn((Text::new(inputs), font(11.5), TextColor(DIM), layout));
            });
    });
}

/// Lights up what is used.
pub fn light_up(
    mut rows: Query<(&mut Row, &mut BackgroundColor, &mut BorderColor)>,
    mut numbers: Query<(&Says, &mut Text)>,
    values: ActionValues,
    mut performed: MessageReader<ActionPerformed>,
    time: Res<Time>,
) {
    let pressed: Vec<_> = performed.read().map(|performed| performed.action.name).collect();
    for (mut row, mut background, mut bar) in &mut rows {
        let used = values.get(row.action.name).is_some_and(|says| says.held);
        if used || pressed.contains(&row.action.name) {
            row.glow = AFTERGLOW;
        }
        let alpha = row.glow / AFTERGLOW;
        background.set_if_neq(BackgroundColor(LIT.with_alpha(TINT * alpha)));
        bar.set_if_neq(BorderColor::all(LIT.with_alpha(alpha)));
        row.glow = (row.glow - time.delta_secs()).max(0.0);
    }
    for (Says(name), mut text) in &mut numbers {
        let says = values.get(name).filter(|says| says.held);
        let says = says.map(|says| match (says.info.unit, says.value) {
            ("", _) => String::new(),
            (_, Vec2 { x, y: 0.0 }) => format!("{x:+.2}"),
            (_, Vec2 { x, y }) => format!("{x:+.1} {y:+.1}"),
        });
        let says = says.unwrap_or_default();
        if text.0 != says {
            text.0 = says;
        }
    }
}
