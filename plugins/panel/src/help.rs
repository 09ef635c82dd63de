//! What does what on the device in hand.

use bevy::prelude::*;
use bevy_egui::egui::{
    self, Align2, Area, Color32, Frame, Id, Margin, Order, RichText, Stroke, vec2,
};
use farlight_controls::{
    ActiveDevice, ControlsInForce, ControlsStatus,
    bindings::{HelpLine, first_hint, help},
};

use crate::style::{ACCENT, LINE, SLATE, TEXT, WEAK};

/// Seconds until the hint of the first screen goes.
const HINT: f32 = 20.0;

/// The card with all actions.
pub(crate) fn overlay(ctx: &egui::Context, world: &World, opacity: f32, scroll: f32) {
    let (Some(in_force), Some(device)) =
        (world.get_resource::<ControlsInForce>(), world.get_resource::<ActiveDevice>())
    else {
        return;
    };
    let added = world.get_resource::<ControlsStatus>().map_or(&[][..], |status| &status.added);
    let lines = help(&in_force.bindings, device.device, added);
    let screen = ctx.content_rect();
    let area = Area::new(Id::new("farlight help"))
        .order(Order::Foreground)
        .anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0))
        .constrain_to(screen);
    area.show(ctx, |ui| {
        card(opacity).show(ui, |ui| {
            let room = screen.size() - vec2(72.0, 96.0);
            ui.set_max_size(room);
            ui.horizontal(|ui| {
                ui.label(RichText::new("Controls").heading().color(Color32::WHITE));
                let name = device.name.clone().unwrap_or_else(|| device.device.label().into());
                ui.label(RichText::new(name).color(WEAK));
            });
            ui.add_space(8.0);
            egui::ScrollArea::vertical().max_height(room.y).show(ui, |ui| {
                // What fits: a column is about 400 wide.
                let count = if room.x > 1220.0 {
                    3
                } else if room.x > 820.0 {
                    2
                } else {
                    1
                };
                if scroll != 0.0 {
                    ui.scroll_with_delta(vec2(0.0, scroll * 20.0));
                }
                ui.horizontal_top(|ui| {
                    ui.spacing_mut().item_spacing.x = 28.0;
                    ui.spacing_mut().interact_size.y = 18.0;
                    for column in columns(&lines, count) {
                        // Labels of a column have one width, so that inputs stand below each other.
                        let labels = column.iter().flat_map(|group| group.iter());
                        let width =
                            labels.map(|line| text_width(ui, line.label)).fold(0.0, f32::max);
                        ui.vertical(|ui| column.iter().for_each(|group| block(ui, group, width)));
                    }
                });
            });
        });
    });
}

/// The frame of what floats.
pub(crate) fn card(opacity: f32) -> Frame {
    Frame::new()
        .fill(SLATE.gamma_multiply(opacity))
        .stroke(Stroke::new(1.0, LINE))
        .corner_radius(10)
        .inner_margin(Margin::symmetric(18, 14))
}

/// Groups of lines in columns that are about equally long.
fn columns(lines: &[HelpLine], count: usize) -> Vec<Vec<&[HelpLine]>> {
    let groups: Vec<&[HelpLine]> = lines.chunk_by(|a, b| a.group == b.group).collect();
    let height = |group: &[HelpLine]| group.len() + 2;
    let whole: usize = groups.iter().map(|group| height(group)).sum();
    let mut columns = vec![Vec::new()];
    let mut used = 0;
    for group in groups {
        let half = height(group) / 2;
        let full = (used + half) * count >= whole * columns.len();
        if full && columns.len() < count && columns.last().is_some_and(|last| !last.is_empty()) {
            columns.push(Vec::new());
        }
        used += height(group);
        if let Some(last) = columns.last_mut() {
            last.push(group);
        }
    }
    columns
}

fn text_width(ui: &egui::Ui, text: &str) -> f32 {
    let text = egui::WidgetText::from(RichText::new(text).size(13.0));
    text.into_galley(ui, None, f32::INFINITY, egui::FontSelection::Default).size().x
}

fn block(ui: &mut egui::Ui, group: &[HelpLine], width: f32) {
    let Some(first) = group.first() else { return };
    ui.label(RichText::new(first.group).color(ACCENT).size(13.0));
    let grid =
        egui::Grid::new(first.group).num_columns(2).spacing([16.0, 2.0]).min_row_height(18.0);
    grid.show(ui, |ui| {
        for line in group {
            ui.horizontal(|ui| {
                ui.set_min_width(width);
                ui.label(RichText::new(line.label).color(WEAK).size(13.0));
            });
            ui.label(RichText::new(&line.inputs).color(TEXT).size(13.0));
            ui.end_row();
        }
    });
    ui.add_space(10.0);
}

/// Which inputs open the menu and help: said until they were used, or for a while.
#[derive(Resource, Default)]
pub(crate) struct Hint {
    seconds: f32,
    known: bool,
}

impl Hint {
    /// Somebody found the menu or help.
    pub(crate) fn found(&mut self) {
        self.known = true;
    }

    /// How visible it is, 0 to 1.
    pub(crate) fn opacity(&self) -> f32 {
        (HINT - self.seconds).clamp(0.0, 1.0)
    }

    /// Time passes; once it is known it goes within a second.
    pub(crate) fn pass(&mut self, seconds: f32) {
        self.seconds += seconds;
        if self.known {
            self.seconds = self.seconds.max(HINT - 1.0);
        }
    }
}

/// Says it, at the lower left.
pub(crate) fn hint(ctx: &egui::Context, world: &World, visible: f32) {
    let (Some(in_force), Some(device)) =
        (world.get_resource::<ControlsInForce>(), world.get_resource::<ActiveDevice>())
    else {
        return;
    };
    let text = first_hint(&in_force.bindings, device.device);
    if text.is_empty() {
        return;
    }
    let area = Area::new(Id::new("farlight hint"))
        .order(Order::Middle)
        .interactable(false)
        .anchor(Align2::LEFT_BOTTOM, vec2(14.0, -14.0));
    area.show(ctx, |ui| {
        ui.set_opacity(visible);
        card(0.8).inner_margin(Margin::symmetric(12, 7)).show(ui, |ui| {
            ui.add(egui::Label::new(RichText::new(text).color(TEXT)).extend());
        });
    });
}
