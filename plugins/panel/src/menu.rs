//! The menu: all sections, foldable, in a window that scrolls.

use bevy::prelude::*;
use bevy_egui::egui::{
    self, CollapsingHeader, Color32, Id, Margin, Rect, RichText, ScrollArea, Sense, Ui, pos2, vec2,
};

use crate::{
    PanelState,
    fields::WIDTH,
    help::card,
    sections::{Section, Sections},
    steer,
    style::{ACCENT, TEXT, WEAK},
};

/// Where a menu may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Room {
    /// On a screen: at its right edge, movable and resizable.
    Screen,
    /// It fills its canvas, except for what is below it.
    World,
}

/// What steers it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Steered {
    pub(crate) scroll: f32,
    pub(crate) by_focus: bool,
}

/// Points below a menu in the world, for notifications.
const BELOW: f32 = 56.0;

/// Draws it.
pub(crate) fn show(
    ctx: &egui::Context,
    world: &mut World,
    room: Room,
    opacity: f32,
    steered: Steered,
) {
    let screen = ctx.content_rect();
    let sections = world.resource::<Sections>().0.clone();
    let unfold = match world.resource::<PanelState>().unfold {
        Some(_) => world.resource_mut::<PanelState>().unfold.take(),
        None => None,
    };
    let window = egui::Window::new("farlight menu")
        .title_bar(false)
        .collapsible(false)
        .frame(card(opacity).inner_margin(Margin::symmetric(0, 12)))
        .constrain_to(screen.shrink(4.0));
    let window = match room {
        Room::Screen => {
            let width = 360.0_f32.min(screen.width() - 24.0);
            let height = (screen.height() - 28.0).clamp(120.0, 760.0);
            window
                .default_pos(pos2(screen.right() - width - 14.0, screen.top() + 14.0))
                .default_size(vec2(width, height))
                .min_size(vec2(260.0, 120.0))
                .max_height((screen.height() - 28.0).max(120.0))
                .resizable(true)
        }
        Room::World => {
            let max = screen.max - vec2(1.0, BELOW);
            window.fixed_rect(Rect::from_min_max(screen.min + vec2(1.0, 1.0), max)).movable(false)
        }
    };
    window.show(ctx, |ui| {
        if room == Room::World {
            ui.set_min_size(ui.available_size());
        }
        heading(ui, world);
        let output = ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 3.0;
            let width = ui.available_width() - 36.0;
            for (at, section) in sections.iter().enumerate() {
                fold(ui, world, section, (at, unfold), width);
            }
            if steered.scroll != 0.0 {
                ui.scroll_with_delta(vec2(0.0, steered.scroll * 24.0));
            }
            let focus = ui.ctx().memory(|memory| memory.focused());
            let seen = Id::new("farlight focus seen");
            if steered.by_focus && ui.data(|data| data.get_temp::<Option<Id>>(seen)) != Some(focus)
            {
                ui.data_mut(|data| data.insert_temp(seen, focus));
                if let Some(rect) = steer::focused(ui.ctx()) {
                    ui.scroll_to_rect(rect.expand(30.0), None);
                }
            }
        });
        if steered.by_focus {
            steer::ring(ui.ctx(), ui.clip_rect().union(output.inner_rect));
        }
    });
}

fn heading(ui: &mut Ui, world: &mut World) {
    ui.horizontal(|ui| {
        ui.add_space(18.0);
        ui.label(RichText::new("Settings").heading().color(Color32::WHITE));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.add_space(14.0);
            if cross(ui).clicked() {
                world.resource_mut::<PanelState>().menu = false;
            }
            if ui
                .add(egui::Button::new(RichText::new("Controls").color(WEAK)).frame(false))
                .clicked()
            {
                let mut state = world.resource_mut::<PanelState>();
                state.help = !state.help;
            }
        });
    });
    ui.add_space(6.0);
    let (line, _) = ui.allocate_exact_size(vec2(ui.available_width(), 1.0), Sense::hover());
    ui.painter().rect_filled(line, 0.0, crate::style::LINE);
}

fn cross(ui: &mut Ui) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(vec2(24.0, 24.0), Sense::click());
    let colour = if response.hovered() || response.has_focus() { ACCENT } else { WEAK };
    let stroke = egui::Stroke::new(1.6, colour);
    let arm = 5.0;
    for end in [vec2(arm, arm), vec2(arm, -arm)] {
        ui.painter().line_segment([rect.center() - end, rect.center() + end], stroke);
    }
    response.on_hover_text("Close")
}

fn fold(
    ui: &mut Ui,
    world: &mut World,
    section: &Section,
    (at, unfold): (usize, Option<&str>),
    width: f32,
) {
    egui::Frame::new().inner_margin(Margin { left: 18, right: 18, top: 3, bottom: 1 }).show(
        ui,
        |ui| {
            ui.data_mut(|data| data.insert_temp(Id::new(WIDTH), width));
            let title = RichText::new(section.title).color(TEXT).size(15.0);
            CollapsingHeader::new(title)
                .id_salt(section.title)
                .default_open(at == 0)
                .open(unfold.map(|title| title == section.title))
                .show_unindented(ui, |ui| {
                    section.draw(ui, world);
                    ui.add_space(6.0);
                });
        },
    );
    let (line, _) = ui.allocate_exact_size(vec2(ui.available_width(), 1.0), Sense::hover());
    ui.painter().rect_filled(line, 0.0, crate::style::LINE.gamma_multiply(0.6));
}
