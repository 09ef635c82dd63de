//! Switches and choices.

use bevy_egui::egui::{
    self, Align2, Color32, FontSelection, Rect, Response, Sense, Ui, WidgetText, pos2, vec2,
};

use super::number::arrows;
use crate::style::{ACCENT, LINE, RAISED, SLATE, TEXT, WEAK};

/// A switch.
pub(crate) fn switch(ui: &mut Ui, on: &mut bool) -> bool {
    let height = ui.spacing().interact_size.y;
    let before = *on;
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.add_space(6.0);
        let (rect, response) = ui.allocate_exact_size(vec2(36.0, height), Sense::click());
        if response.clicked() {
            *on = !*on;
        }
        match arrows(ui, &response) {
            0 => {}
            more => *on = more > 0,
        }
        let place = ui.ctx().animate_bool_responsive(response.id, *on);
        let track = Rect::from_center_size(rect.center(), vec2(36.0, 20.0));
        let off = if response.hovered() { LINE.gamma_multiply(1.3) } else { LINE };
        ui.painter().rect_filled(track, 10.0, off.lerp_to_gamma(ACCENT, place));
        let x = egui::lerp(track.left() + 10.0..=track.right() - 10.0, place);
        let knob = TEXT.lerp_to_gamma(SLATE, place);
        ui.painter().circle_filled(pos2(x, track.center().y), 7.0, knob);
    });
    *on != before
}

/// One of a few: all side by side where they fit, otherwise one at a time.
pub(crate) fn choice(ui: &mut Ui, names: &[String], chosen: usize) -> Option<usize> {
    let galleys: Vec<_> = names
        .iter()
        .map(|name| {
            let text = WidgetText::from(name.as_str());
            text.into_galley(ui, None, f32::INFINITY, FontSelection::Default)
        })
        .collect();
    let widest = galleys.iter().map(|galley| galley.size().x).fold(0.0, f32::max) + 16.0;
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let rect = rect.shrink2(vec2(0.0, 1.0));
    ui.painter().rect_filled(rect, 5.0, RAISED);
    let count = names.len().max(1);
    let step = |by: i32| (chosen as i32 + by).rem_euclid(count as i32) as usize;
    let mut next = match arrows(ui, &response) {
        0 => None,
        by => Some(step(by)),
    };
    let clicked = response.clicked();
    let pointer = response.interact_pointer_pos();
    if widest * count as f32 <= rect.width() {
        let width = rect.width() / count as f32;
        for (at, galley) in galleys.into_iter().enumerate() {
            let min = pos2(rect.left() + width * at as f32, rect.top());
            let cell = Rect::from_min_size(min, vec2(width, rect.height()));
            let hovered = response.hover_pos().is_some_and(|pointer| cell.contains(pointer));
            if clicked && pointer.is_some_and(|pointer| cell.contains(pointer)) {
                next = Some(at);
            }
            let colour = if at == chosen {
                ui.painter().rect_filled(cell.shrink(2.0), 4.0, ACCENT);
                SLATE
            } else if hovered {
                Color32::WHITE
            } else {
                WEAK
            };
            let place = Align2::CENTER_CENTER.align_size_within_rect(galley.size(), cell).min;
            ui.painter().galley_with_override_text_color(place, galley, colour);
        }
        // Space or Enter, without a pointer.
        if clicked && pointer.is_none_or(|pointer| !rect.contains(pointer)) {
            next = Some(step(1));
        }
    } else {
        if clicked {
            let back = pointer.is_some_and(|pointer| pointer.x < rect.left() + rect.width() / 3.0);
            next = Some(step(if back { -1 } else { 1 }));
        }
        let colour = if response.hovered() { Color32::WHITE } else { TEXT };
        if let Some(galley) = galleys.into_iter().nth(chosen) {
            let place = Align2::CENTER_CENTER.align_size_within_rect(galley.size(), rect).min;
            let inside = ui.painter().with_clip_rect(rect.shrink2(vec2(20.0, 0.0)));
            inside.galley_with_override_text_color(place, galley, colour);
        }
        chevron(ui, &response, rect.left() + 11.0, -1.0);
        chevron(ui, &response, rect.right() - 11.0, 1.0);
    }
    next.filter(|next| *next != chosen)
}

fn chevron(ui: &Ui, response: &Response, x: f32, direction: f32) {
    let near = response.hover_pos().is_some_and(|pointer| (pointer.x - x).abs() < 20.0);
    let colour = if near { ACCENT } else { WEAK };
    let y = response.rect.center().y;
    let points =
        [-1.0, 0.0, 1.0].map(|at: f32| pos2(x + direction * (2.0 - 4.0 * at.abs()), y + 4.5 * at));
    ui.painter().add(egui::Shape::line(points.to_vec(), egui::Stroke::new(1.6, colour)));
}
