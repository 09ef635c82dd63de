//! Lines that say what happened, and go.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, Area, Id, Margin, Order, RichText, vec2};

use crate::{
    Notification,
    help::card,
    style::{ACCENT, PROBLEM, TEXT},
};

/// Lines at a time.
const MOST: usize = 4;
/// Seconds that a line stays; a problem stays twice as long.
const STAYS: f32 = 3.5;
/// Seconds that it fades.
const FADES: f32 = 0.4;

/// A line that is shown.
#[derive(Clone, Debug)]
struct Line {
    says: Notification,
    left: f32,
}

/// The lines that are shown, oldest first.
#[derive(Resource, Default)]
pub(crate) struct Lines(Vec<Line>);

impl Lines {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn push(&mut self, says: Notification) {
        let left = if says.problem { 2.0 * STAYS } else { STAYS };
        // What is said again, or says a new value of the same thing, takes the old line's place.
        let subject = |text: &str| text.split(':').next().unwrap_or_default().to_string();
        let same = |line: &Line| {
            line.says == says
                || says.text.contains(':') && subject(&line.says.text) == subject(&says.text)
        };
        match self.0.iter_mut().find(|line| same(line)) {
            Some(line) => *line = Line { says, left },
            None => self.0.push(Line { says, left }),
        }
        let surplus = self.0.len().saturating_sub(MOST);
        self.0.drain(..surplus);
    }
}

/// Takes what was said, and lets time pass.
pub(crate) fn collect(
    mut lines: ResMut<Lines>,
    mut said: MessageReader<Notification>,
    time: Res<Time<Real>>,
) {
    if lines.is_empty() && said.is_empty() {
        return;
    }
    let passed = time.delta_secs();
    for line in &mut lines.0 {
        line.left -= passed;
    }
    lines.0.retain(|line| line.left > 0.0);
    for says in said.read() {
        lines.push(says.clone());
    }
}

/// Shows them at the bottom, the newest below.
pub(crate) fn show(ctx: &egui::Context, lines: &Lines) {
    if lines.is_empty() {
        return;
    }
    let area = Area::new(Id::new("farlight notifications"))
        .order(Order::Tooltip)
        .interactable(false)
        .anchor(Align2::CENTER_BOTTOM, vec2(0.0, -18.0));
    area.show(ctx, |ui| {
        ui.vertical_centered(|ui| {
            for line in &lines.0 {
                ui.scope(|ui| {
                    ui.set_opacity((line.left / FADES).clamp(0.0, 1.0));
                    card(0.92).inner_margin(Margin::symmetric(14, 7)).show(ui, |ui| {
                        ui.horizontal(|ui| {
                            let colour = if line.says.problem { PROBLEM } else { ACCENT };
                            let (rect, _) =
                                ui.allocate_exact_size(vec2(7.0, 7.0), egui::Sense::hover());
                            ui.painter().circle_filled(rect.center(), 3.5, colour);
                            let text = RichText::new(&line.says.text).color(TEXT);
                            ui.add(egui::Label::new(text).extend());
                        });
                    });
                });
            }
        });
    });
    ctx.request_repaint();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_few_and_repetitions_are_one() {
        let mut lines = Lines::default();
        for at in 0..10 {
            lines.push(Notification::new(format!("line {at}")));
        }
        assert_eq!(lines.0.len(), MOST);
        lines.push(Notification::new("Lights: 5"));
        lines.push(Notification::new("Lights: 6"));
        lines.push(Notification::new("Lights: 6"));
        assert_eq!(lines.0.len(), MOST);
        let lights = lines.0.iter().filter(|line| line.says.text.starts_with("Lights"));
        assert_eq!(lights.count(), 1);
    }
}
