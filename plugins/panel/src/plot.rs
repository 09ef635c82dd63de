//! Small plots of what happened last.

use std::time::Duration;

use bevy_egui::egui::{self, Align2, Sense, Shape, Stroke, Ui, pos2, vec2};
use farlight_core::TimeWindow;

use crate::{
    fields::{Spec, row, show},
    style::{ACCENT, LINE, TEXT, WEAK},
};

/// Points of a plot at most: more than its width has nothing to show them.
const POINTS: usize = 160;
/// Its height, in points of the screen.
const HEIGHT: f32 = 44.0;

/// A time as people read it.
pub(crate) fn time_text(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    let (value, unit) = if seconds >= 1.0 {
        (seconds, "s")
    } else if seconds >= 1e-3 || seconds == 0.0 {
        (seconds * 1e3, "ms")
    } else {
        (seconds * 1e6, "µs")
    };
    Spec { unit, ..Default::default() }.text(value)
}

/// The last durations of something: the newest in words, a plot, the median and the worst.
pub(crate) fn times(ui: &mut Ui, label: &str, docs: Option<&str>, window: &TimeWindow) {
    let Some(last) = window.last() else {
        row(ui, label, docs, |ui| show(ui, "none"));
        return;
    };
    let values: Vec<f64> =
        window.iter().rev().take(POINTS).map(|time| time.as_secs_f64() * 1e3).collect();
    let newest_last: Vec<f64> = values.into_iter().rev().collect();
    row(ui, label, docs, |ui| show(ui, time_text(last)));
    plot(ui, &newest_last, "ms");
}

/// A line through values, oldest first, from zero up to the largest.
pub fn plot(ui: &mut Ui, values: &[f64], unit: &'static str) {
    let size = vec2(ui.available_width(), HEIGHT);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect.expand(1.0));
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let known = || values.iter().copied().filter(|value| value.is_finite());
    let top = nice(known().fold(0.0, f64::max));
    let inside = rect.shrink2(vec2(4.0, 5.0));
    for part in [0.0, 0.5, 1.0] {
        let y = egui::lerp(inside.bottom()..=inside.top(), part);
        painter.hline(inside.x_range(), y, Stroke::new(0.5, LINE));
    }
    let step = inside.width() / (POINTS - 1) as f32;
    let shown = &values[values.len().saturating_sub(POINTS)..];
    let line: Vec<_> = shown
        .iter()
        .rev()
        .enumerate()
        .filter(|(_, value)| value.is_finite())
        .map(|(back, value)| {
            let y = egui::lerp(inside.bottom()..=inside.top(), (value / top) as f32);
            pos2(inside.right() - step * back as f32, y)
        })
        .collect();
    if line.len() > 1 {
        painter.add(Shape::line(line, Stroke::new(1.5, ACCENT)));
    } else if let Some(point) = line.first() {
        painter.circle_filled(*point, 1.5, ACCENT);
    }
    let font = egui::TextStyle::Small.resolve(ui.style());
    let text = |value| Spec { unit, ..Default::default() }.text(value);
    let place = inside.left_top() + vec2(2.0, -2.0);
    painter.text(place, Align2::LEFT_TOP, text(top), font.clone(), WEAK);
    let mean = known().sum::<f64>() / known().count().max(1) as f64;
    let place = inside.left_bottom() + vec2(2.0, 2.0);
    painter.text(place, Align2::LEFT_BOTTOM, format!("mean {}", text(mean)), font, TEXT);
}

/// The next of 1, 2, 5, 10, ... that is not smaller.
fn nice(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return 1.0;
    }
    let decade = 10f64.powf(value.log10().floor());
    let leading = value / decade;
    decade * [1.0, 2.0, 5.0].into_iter().find(|step| leading <= *step).unwrap_or(10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_at_round_numbers() {
        for (value, top) in [(0.0, 1.0), (0.7, 1.0), (1.2, 2.0), (34.0, 50.0), (99.0, 100.0)] {
            assert!((nice(value) - top).abs() < 1e-9 * top, "{value}: {}", nice(value));
        }
        assert_eq!(time_text(Duration::from_micros(1234)), "1.23 ms");
        assert_eq!(time_text(Duration::from_nanos(850)), "0.85 µs");
    }
}
