//! Keys, and what is on screen about them.

use std::time::Duration;

use bevy::prelude::*;
use farlight::{core::TimeWindow, prelude::*};

use super::{
    motion::Traveller,
    scene::{Ball, Lamp},
};

/// The panel with keys and state.
#[derive(Component)]
pub struct Hud;

/// The text that changes.
#[derive(Component)]
pub struct State;

const KEYS: &str = "\
I          indirect light on / off
L          lightmap alone
Space      stop the lamp
B          stop the ball
+  -       lamp faster, slower
drag, arrows, wheel   look around
H          hide this
";

/// Makes the panel.
pub fn spawn(mut commands: Commands) {
    let text = |size: f32| TextFont { font_size: FontSize::Px(size), ..default() };
    commands
        .spawn((
            Hud,
            Node {
                position_type: PositionType::Absolute,
                top: px(12),
                left: px(12),
                padding: UiRect::all(px(10)),
                flex_direction: FlexDirection::Column,
                row_gap: px(8),
                border_radius: BorderRadius::all(px(6)),
                ..default()
            },
            BackgroundColor(Color::srgba(0.0, 0.0, 0.0, 0.55)),
        ))
        .with_children(|panel| {
            panel.spawn((Text::new(KEYS), text(13.0), TextColor(Color::srgb(0.85, 0.85, 0.82))));
            panel.spawn((
                State,
                Text::default(),
                text(13.0),
                TextColor(Color::srgb(1.0, 0.8, 0.45)),
            ));
        });
}

/// Acts on keys.
pub fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    mut view: ResMut<GiView>,
    mut lamps: Query<&mut Traveller, (With<Lamp>, Without<Ball>)>,
    mut balls: Query<&mut Traveller, With<Ball>>,
    mut huds: Query<&mut Visibility, With<Hud>>,
) {
    if keys.just_pressed(KeyCode::KeyI) {
        *view = toggled(*view, GiView::DirectOnly);
    }
    if keys.just_pressed(KeyCode::KeyL) {
        *view = toggled(*view, GiView::LightmapOnly);
    }
    for mut lamp in &mut lamps {
        if keys.just_pressed(KeyCode::Space) {
            lamp.paused = !lamp.paused;
        }
        if keys.any_just_pressed([KeyCode::Equal, KeyCode::NumpadAdd]) {
            lamp.speed = (lamp.speed * 1.25).min(4.0);
        }
        if keys.any_just_pressed([KeyCode::Minus, KeyCode::NumpadSubtract]) {
            lamp.speed = (lamp.speed / 1.25).max(0.05);
        }
    }
    for mut ball in &mut balls {
        if keys.just_pressed(KeyCode::KeyB) {
            ball.paused = !ball.paused;
        }
    }
    for mut visibility in &mut huds {
        if keys.just_pressed(KeyCode::KeyH) {
            visibility.toggle_visible_hidden();
        }
    }
}

fn toggled(view: GiView, other: GiView) -> GiView {
    if view == other { GiView::Full } else { other }
}

/// What the panel showed last.
#[derive(Default)]
pub struct Last {
    /// When, in seconds since the start.
    at: f32,
    /// Lighting updates.
    updates: u64,
    /// Bytes from the server.
    received: u64,
}

/// Lines about the connection to a lighting server.
fn link_text(link: &LinkStatus, bytes_per_s: f32, latency: &TimeWindow) -> String {
    let ms = |time: Duration| format!("{:.1} ms", time.as_secs_f32() * 1e3);
    let state = match &link.state {
        LinkState::Connecting => "connecting".into(),
        LinkState::Connected => "connected".into(),
        LinkState::GivenUp => "given up".into(),
        LinkState::Reconnecting { attempt, retry_in, .. } => {
            let when = match retry_in.as_secs_f32() {
                0.0 => "now".into(),
                seconds => format!("in {seconds:.1} s"),
            };
            format!("reconnecting {when} (attempt {attempt})")
        }
    };
    let rtt = link.rtt.map_or("unknown".into(), ms);
    // Of the last second or two, not of all that is remembered.
    let mut latest: Vec<Duration> = latency.iter().rev().take(20).collect();
    latest.sort_unstable();
    let latency = latest.get(latest.len() / 2).copied().map_or("none yet".into(), ms);
    format!(
        "\nserver {}, {state}\nround trip {rtt}, {:.1} kB/s, light after {latency}",
        link.peer,
        bytes_per_s * 1e-3,
    )
}

/// Writes what is going on into the panel, four times a second.
pub fn show(
    time: Res<Time>,
    status: Res<GiStatus>,
    view: Res<GiView>,
    lamps: Query<&Traveller, With<Lamp>>,
    mut texts: Query<&mut Text, With<State>>,
    mut last: Local<Last>,
) {
    let now = time.elapsed_secs();
    let passed = now - last.at;
    if passed < 0.25 {
        return;
    }
    let rate = (status.updates - last.updates) as f32 / passed;
    let received = status.link.as_ref().map_or(0, |link| link.received_bytes);
    let link = status.link.as_ref().map_or(String::new(), |link| {
        let bytes_per_s = received.saturating_sub(last.received) as f32 / passed;
        link_text(link, bytes_per_s, &status.timings.latency)
    });
    *last = Last { at: now, updates: status.updates, received };
    let speed = lamps.iter().map(|l| if l.paused { 0.0 } else { l.speed }).fold(0.0, f32::max);
    let state = match &status.state {
        GiState::Failed { reason } => format!("failed: {reason}"),
        GiState::Disconnected { reason } => format!("disconnected: {reason}"),
        state => format!("{state:?}").to_lowercase(),
    };
    let shown = match *view {
        GiView::Full => "all light",
        GiView::DirectOnly => "direct light only",
        GiView::LightmapOnly => "lightmap alone",
    };
    let frame = status.timings.frame.cpu_stats();
    for mut text in &mut texts {
        text.0 = format!(
            "{shown}, {state}\n{rate:.0} lighting updates a second, estimated error {:.0} %\n\
             lamp {speed:.2} m/s\n{} meshes lit, {} left out, our systems {:.2} ms a frame{link}",
            status.quality.relative_error * 100.0,
            status.receivers,
            status.left_out.len(),
            frame.median.as_secs_f32() * 1e3,
        );
    }
}
