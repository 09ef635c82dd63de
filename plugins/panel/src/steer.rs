//! Panels by keys, gamepad and sticks: actions become what egui hears.

use bevy::prelude::*;
use bevy_egui::egui::{self, Event, Key, Modifiers};
use farlight_controls::{Controls, actions};

use crate::{PanelState, help::Hint, world::Pointed};

/// Seconds until what is held repeats.
const PATIENCE: f32 = 0.4;
/// Seconds between repetitions.
const REPEATS: f32 = 0.08;

/// What actions say to a panel in this frame.
#[derive(Resource, Default)]
pub(crate) struct Steering {
    pub(crate) events: Vec<Event>,
    /// What a window's keyboard says to a text field in the world.
    pub(crate) typed: Vec<Event>,
    /// Lines, up is positive.
    pub(crate) scroll: f32,
    /// Whether the focus is what was used last, rather than a pointer.
    pub(crate) by_focus: bool,
    /// Close what is open.
    pub(crate) back: bool,
    /// Seconds that next, previous, more and less have been held.
    held: [f32; 4],
}

impl Steering {
    fn key(&mut self, key: Key, modifiers: Modifiers) {
        for pressed in [true, false] {
            let event = Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
            self.events.push(event);
        }
        self.by_focus = true;
    }
}

/// Opens and closes.
pub(crate) fn open_and_close(
    controls: Controls,
    mut state: ResMut<PanelState>,
    mut hint: ResMut<Hint>,
) {
    if controls.started::<actions::Menu>() {
        state.menu = !state.menu;
        hint.found();
    }
    if controls.started::<actions::Help>() {
        state.help = !state.help;
        hint.found();
    }
}

/// Notes what actions say to the open panel.
pub(crate) fn steer(
    controls: Controls,
    state: Res<PanelState>,
    time: Res<Time<Real>>,
    pointed: Res<Pointed>,
    mut steering: ResMut<Steering>,
) {
    let steering = &mut *steering;
    steering.events.clear();
    steering.typed.clear();
    steering.scroll = 0.0;
    steering.back = (state.menu || state.help) && controls.started::<actions::PanelBack>();
    if state.help && !state.menu {
        steering.scroll = controls.axis::<actions::PanelScroll>();
    }
    if !state.menu {
        steering.held = [0.0; 4];
        steering.by_focus = false;
        return;
    }
    let ways = [
        (
            controls.started::<actions::PanelNext>(),
            controls.held::<actions::PanelNext>(),
            (Key::Tab, Modifiers::NONE),
        ),
        (
            controls.started::<actions::PanelPrevious>(),
            controls.held::<actions::PanelPrevious>(),
            (Key::Tab, Modifiers::SHIFT),
        ),
        (
            controls.started::<actions::PanelMore>(),
            controls.held::<actions::PanelMore>(),
            (Key::ArrowRight, Modifiers::NONE),
        ),
        (
            controls.started::<actions::PanelLess>(),
            controls.held::<actions::PanelLess>(),
            (Key::ArrowLeft, Modifiers::NONE),
        ),
    ];
    for (at, (started, held, (key, modifiers))) in ways.into_iter().enumerate() {
        let before = steering.held[at];
        steering.held[at] = if held && !started { before + time.delta_secs() } else { 0.0 };
        let repetitions = |seconds: f32| ((seconds - PATIENCE) / REPEATS).floor().max(-1.0);
        if started || repetitions(steering.held[at]) > repetitions(before) && before > 0.0 {
            steering.key(key, modifiers);
        }
    }
    // The trigger of a hand that points is a press where it points.
    if controls.started::<actions::PanelPress>() && pointed.hands == [false; 2] {
        steering.key(Key::Enter, Modifiers::NONE);
    }
    steering.scroll = controls.axis::<actions::PanelScroll>();
}

/// Leaves of what a window's keyboard says only what a text field needs: everything else comes as
/// an action, once.
pub(crate) fn keep_text(events: &mut Vec<Event>, writing: bool) {
    events.retain(|event| match event {
        Event::Key { .. } | Event::Text(_) | Event::Ime(_) => writing,
        Event::Copy | Event::Cut | Event::Paste(_) => writing,
        _ => true,
    });
}

/// A ring round what has the focus.
pub(crate) fn ring(ctx: &egui::Context, clip: egui::Rect) {
    let Some(rect) = focused(ctx) else { return };
    let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::new("farlight focus"));
    let painter = ctx.layer_painter(layer).with_clip_rect(clip.expand(4.0));
    let stroke = egui::Stroke::new(2.0, crate::style::ACCENT);
    painter.rect_stroke(rect.expand(3.0), 7.0, stroke, egui::StrokeKind::Middle);
}

/// Where it is.
pub(crate) fn focused(ctx: &egui::Context) -> Option<egui::Rect> {
    let id = ctx.memory(|memory| memory.focused())?;
    ctx.read_response(id).map(|response| response.rect)
}
