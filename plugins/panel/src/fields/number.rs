//! Numbers: how they are shown, slid, stepped and typed.

use std::ops::RangeInclusive;

use bevy_egui::egui::{self, Align2, EventFilter, Id, Key, Rect, Response, Sense, Ui, pos2, vec2};

use crate::style::{ACCENT, LINE, RAISED, TEXT, WEAK};

/// What is known of a number.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Spec {
    pub(crate) range: Option<RangeInclusive<f64>>,
    pub(crate) unit: &'static str,
    pub(crate) step: Option<f64>,
    pub(crate) logarithmic: bool,
    pub(crate) integer: bool,
}

/// Ranges over so many times are slid by factors.
const LOGARITHMIC_FROM: f64 = 1000.0;
/// Steps of keys over a slider's whole way.
const KEY_STEPS: f64 = 20.0;
/// Width of a value beside its slider, in points.
const VALUE_WIDTH: f32 = 76.0;

impl Spec {
    fn is_logarithmic(&self) -> bool {
        self.range.as_ref().is_some_and(|range| {
            let (low, high) = (*range.start(), *range.end());
            low > 0.0 && (self.logarithmic || high / low >= LOGARITHMIC_FROM)
        })
    }

    /// From 0 to 1 along the slider.
    fn place(&self, range: &RangeInclusive<f64>, value: f64) -> f64 {
        let (low, high) = (*range.start(), *range.end());
        let place = if self.is_logarithmic() {
            (value.max(low) / low).ln() / (high / low).ln()
        } else {
            (value - low) / (high - low)
        };
        if place.is_finite() { place.clamp(0.0, 1.0) } else { 0.0 }
    }

    fn at(&self, range: &RangeInclusive<f64>, place: f64) -> f64 {
        let (low, high) = (*range.start(), *range.end());
        let place = place.clamp(0.0, 1.0);
        let value = if self.is_logarithmic() {
            low * (high / low).powf(place)
        } else {
            low + (high - low) * place
        };
        // The ends are exact.
        match place {
            0.0 => low,
            1.0 => high,
            _ => self.fit(self.round(value, range)),
        }
    }

    /// To as many digits as are shown, so that values are the ones that people read.
    fn round(&self, value: f64, range: &RangeInclusive<f64>) -> f64 {
        if let Some(step) = self.step.filter(|step| *step > 0.0) {
            return (value / step).round() * step;
        }
        if self.integer {
            return value.round();
        }
        let size = if self.is_logarithmic() {
            value.abs()
        } else {
            range.start().abs().max(range.end().abs())
        };
        let digit = 10f64.powf((size.max(1e-12).log10()).floor() - 2.0);
        (value / digit).round() * digit
    }

    /// Into the range.
    fn fit(&self, value: f64) -> f64 {
        let value = if self.integer { value.round() } else { value };
        match &self.range {
            Some(range) => value.clamp(*range.start(), *range.end()),
            None => value,
        }
    }

    /// What people read.
    pub(crate) fn text(&self, value: f64) -> String {
        let (value, unit) =
            if self.unit == "%" { (value * 100.0, "%") } else { (value, self.unit) };
        let number = match self.unit {
            _ if self.integer => grouped(value),
            // Nobody reads tenths of a percent of a setting.
            "%" if value.abs() >= 9.95 => grouped(value),
            _ => digits(value),
        };
        if unit.is_empty() {
            number
        } else if unit.starts_with(['/', '°']) {
            number + unit
        } else {
            format!("{number} {unit}")
        }
    }

    fn parse(&self, text: &str) -> Option<f64> {
        let text = text.trim().trim_end_matches(self.unit).trim().replace(',', ".");
        let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let value: f64 = text.parse().ok().filter(|value: &f64| value.is_finite())?;
        Some(self.fit(if self.unit == "%" { value / 100.0 } else { value }))
    }
}

/// A whole number with its thousands apart.
fn grouped(value: f64) -> String {
    let whole = format!("{:.0}", value.abs());
    let mut text = String::from(if value < 0.0 { "−" } else { "" });
    for (at, digit) in whole.chars().enumerate() {
        if at > 0 && (whole.len() - at).is_multiple_of(3) && whole.len() > 4 {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Three digits that count.
fn digits(value: f64) -> String {
    let size = value.abs();
    let text = match size {
        0.0 => "0".into(),
        _ if !size.is_finite() => size.to_string(),
        _ if size >= 999.5 => return grouped(value),
        _ if size >= 99.95 => format!("{size:.0}"),
        _ if size >= 9.995 => format!("{size:.1}"),
        _ if size >= 0.0995 => format!("{size:.2}"),
        _ if size >= 0.000_995 => {
            let text = format!("{size:.4}");
            text.trim_end_matches('0').to_string()
        }
        _ => format!("{size:.1e}"),
    };
    if value < 0.0 { format!("−{text}") } else { text }
}

/// A number that can be changed: a slider where the range is known, and the value to type.
pub(crate) fn edit(ui: &mut Ui, value: &mut f64, spec: &Spec) -> bool {
    let before = *value;
    match &spec.range {
        Some(range) => {
            let width = (ui.available_width() - VALUE_WIDTH - 8.0).max(24.0);
            slider(ui, value, range, spec, width);
            typed(ui, value, spec, Sense::CLICK);
        }
        None => {
            typed(ui, value, spec, Sense::click_and_drag());
        }
    }
    *value != before
}

fn slider(
    ui: &mut Ui,
    value: &mut f64,
    range: &RangeInclusive<f64>,
    spec: &Spec,
    width: f32,
) -> Response {
    let size = vec2(width, ui.spacing().interact_size.y);
    let (rect, response) = ui.allocate_exact_size(size, Sense::drag());
    let radius = 7.0;
    let way = rect.shrink2(vec2(radius, 0.0));
    // A press anywhere on it takes it there.
    if let Some(pointer) = response.interact_pointer_pos() {
        *value = spec.at(range, f64::from((pointer.x - way.left()) / way.width()));
    }
    let steps = arrows(ui, &response);
    if steps != 0 {
        let place = spec.place(range, *value);
        *value = match spec.step {
            Some(step) => spec.fit(*value + step * f64::from(steps)),
            None => {
                let next = spec.at(range, place + f64::from(steps) / KEY_STEPS);
                // Whole numbers move at least by one.
                if next == *value { spec.fit(*value + f64::from(steps)) } else { next }
            }
        };
    }
    let at = way.left() + way.width() * spec.place(range, *value) as f32;
    let painter = ui.painter();
    let rail = Rect::from_center_size(rect.center(), vec2(rect.width(), 4.0));
    painter.rect_filled(rail, 2.0, LINE);
    let done = Rect::from_min_max(rail.min, pos2(at, rail.bottom()));
    painter.rect_filled(done, 2.0, ACCENT.gamma_multiply(0.8));
    let hot = response.hovered() || response.dragged() || response.has_focus();
    let knob = if hot { ACCENT } else { TEXT };
    painter.circle_filled(pos2(at, rect.center().y), if hot { radius } else { 6.0 }, knob);
    response
}

/// Left and right on what has the focus.
pub(crate) fn arrows(ui: &Ui, response: &Response) -> i32 {
    if !response.has_focus() {
        return 0;
    }
    let filter = EventFilter { horizontal_arrows: true, ..Default::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    ui.input(|input| {
        input.num_presses(Key::ArrowRight) as i32 - input.num_presses(Key::ArrowLeft) as i32
    })
}

/// A value that becomes a text field where it is clicked.
fn typed(ui: &mut Ui, value: &mut f64, spec: &Spec, sense: Sense) -> Response {
    let size = vec2(VALUE_WIDTH, ui.spacing().interact_size.y - 2.0);
    let id = ui.next_auto_id();
    let text_id = id.with("text");
    let open: Option<String> = ui.data(|data| data.get_temp(text_id));
    if let Some(mut text) = open {
        let field = egui::TextEdit::singleline(&mut text)
            .id(Id::new(text_id))
            .desired_width(size.x)
            .horizontal_align(egui::Align::RIGHT);
        let response = ui.add_sized(size, field);
        let gone = response.lost_focus();
        if gone {
            if !ui.input(|input| input.key_pressed(Key::Escape))
                && let Some(number) = spec.parse(&text)
            {
                *value = number;
            }
            ui.data_mut(|data| data.remove::<String>(text_id));
        } else {
            ui.data_mut(|data| data.insert_temp(text_id, text));
        }
        return response;
    }
    let (rect, response) = ui.allocate_exact_size(size, sense);
    if response.clicked() {
        let text = if spec.unit == "%" { *value * 100.0 } else { *value };
        let text = if spec.integer { format!("{text:.0}") } else { format!("{text}") };
        ui.data_mut(|data| data.insert_temp(text_id, text));
        ui.memory_mut(|memory| memory.request_focus(Id::new(text_id)));
    } else {
        let size = if spec.integer { 1.0 } else { (value.abs() * 0.05).max(0.01) };
        let step = spec.step.unwrap_or(size);
        let dragged = f64::from(response.drag_delta().x) * step * 0.2;
        let stepped = f64::from(arrows(ui, &response)) * step;
        if dragged != 0.0 && spec.integer {
            // What is less than one is kept until it is one.
            let rest = id.with("rest");
            let sum = ui.data(|data| data.get_temp::<f64>(rest)).unwrap_or(0.0) + dragged;
            ui.data_mut(|data| data.insert_temp(rest, sum.fract()));
            *value = spec.fit(*value + sum.trunc());
        } else if dragged != 0.0 {
            *value = spec.fit(*value + dragged);
        }
        if stepped != 0.0 {
            *value = spec.fit(*value + stepped);
        }
    }
    let framed = sense.senses_drag() || response.hovered();
    if framed {
        ui.painter().rect_filled(rect, 5.0, RAISED);
    }
    let colour = if response.hovered() { egui::Color32::WHITE } else { TEXT };
    ui.painter().text(
        pos2(rect.right() - 6.0, rect.center().y),
        Align2::RIGHT_CENTER,
        spec.text(*value),
        egui::TextStyle::Body.resolve(ui.style()),
        colour,
    );
    response
}

/// A value that can't be changed.
pub(crate) fn show(ui: &mut Ui, text: impl Into<String>) {
    let text = egui::RichText::new(text).color(WEAK);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.add_space(6.0);
        ui.add(egui::Label::new(text).truncate());
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_have_units() {
        let text = |value, unit| Spec { unit, ..Default::default() }.text(value);
        assert_eq!(text(0.94, "%"), "94 %");
        assert_eq!(text(1.25, "m"), "1.25 m");
        assert_eq!(text(-12.345, "°"), "−12.3°");
        assert_eq!(text(0.00123, ""), "0.0012");
        assert_eq!(text(12345.6, "lux"), "12 346 lux");
        assert_eq!(text(2.0e-7, ""), "2.0e-7");
        let whole = Spec { integer: true, ..Default::default() };
        assert_eq!(whole.text(4096.0), "4096");
        assert_eq!(whole.text(1_048_576.0), "1 048 576");
    }

    #[test]
    fn what_is_typed_is_what_is_read() {
        let spec = Spec { range: Some(0.0..=1.0), unit: "%", ..Default::default() };
        assert_eq!(spec.parse("25 %"), Some(0.25));
        assert_eq!(spec.parse("250"), Some(1.0), "out of range");
        assert_eq!(spec.parse("much"), None);
        assert_eq!(spec.parse("NaN"), None);
        let whole = Spec { integer: true, ..Default::default() };
        assert_eq!(whole.parse("1 048 576"), Some(1_048_576.0));
    }

    #[test]
    fn sliders_go_where_they_come_from() {
        for (low, high) in [(0.0, 1.0), (-180.0, 180.0), (0.1, 10_000.0), (1.0, 4096.0)] {
            let spec = Spec { range: Some(low..=high), ..Default::default() };
            let range = low..=high;
            assert_eq!((spec.at(&range, 0.0), spec.at(&range, 1.0)), (low, high));
            for step in 0..=20 {
                let place = f64::from(step) / 20.0;
                let back = spec.place(&range, spec.at(&range, place));
                // Three digits that count are a part of 200 of the way at most.
                assert!((back - place).abs() < 0.005, "{low} {high}: {place} gives {back}");
            }
        }
    }
}
