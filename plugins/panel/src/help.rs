//! What does what on the device in hand.

use bevy::prelude::{Resource, World};
use bevy_egui::egui::{
    self, Align2, Area, Color32, Frame, Id, Margin, Order, RichText, Stroke, Vec2,
    style::ScrollStyle, vec2,
};
use farlight_controls::{
    ActiveDevice, ControlsInForce, ControlsStatus,
    bindings::{HelpLine, first_hint, help},
};

use crate::{
    PanelSettings, PanelState,
    style::{ACCENT, LINE, SLATE, TEXT, WEAK},
};

/// Seconds until the hint of the first screen goes.
const HINT: f32 = 20.0;
/// What the card takes of the screen besides its lines: margins, title, and some of what is behind it.
const AROUND: Vec2 = vec2(56.0, 84.0);
/// Height of letters.
const LETTERS: f32 = 13.0;
/// Between labels and inputs.
const GAP: f32 = 16.0;
/// Between columns.
const BETWEEN: f32 = 28.0;
/// Inputs are not broken into shorter lines for the sake of another column.
const LEAST_INPUTS: f32 = 130.0;
/// More of them are no easier to read.
const MOST_COLUMNS: usize = 3;

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
            let room = screen.size() - AROUND;
            ui.set_max_size(room);
            ui.horizontal(|ui| {
                ui.label(RichText::new("Controls").heading().color(Color32::WHITE));
                let name = device.name.clone().unwrap_or_else(|| device.device.label().into());
                ui.label(RichText::new(name).color(WEAK));
            });
            ui.add_space(8.0);
            // A bar says that there is more below.
            ui.spacing_mut().scroll = ScrollStyle::solid();
            let bar = ui.spacing().scroll.allocated_width();
            egui::ScrollArea::vertical().max_height(room.y).show(ui, |ui| {
                if scroll != 0.0 {
                    ui.scroll_with_delta(vec2(0.0, scroll * 20.0));
                }
                let fitting = fitting(ui, &lines, room - vec2(bar, 0.0));
                ui.horizontal_top(|ui| {
                    ui.spacing_mut().item_spacing.x = BETWEEN;
                    for column in fitting {
                        ui.vertical(|ui| {
                            column.groups.iter().for_each(|group| block(ui, group, column.widths));
                        });
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

/// Groups that stand below each other, and how wide their labels and inputs are.
struct Column<'a> {
    groups: Vec<&'a [HelpLine]>,
    widths: [f32; 2],
}

impl<'a> Column<'a> {
    /// As wide as its texts.
    fn new(ui: &egui::Ui, groups: Vec<&'a [HelpLine]>) -> Self {
        let widest = |text: fn(&HelpLine) -> &str| {
            let lines = groups.iter().flat_map(|group| group.iter());
            lines.map(|line| text_width(ui, text(line))).fold(0.0, f32::max)
        };
        let widths = [widest(|line| line.label), widest(|line| &line.inputs)];
        Self { groups, widths }
    }

    fn width(&self) -> f32 {
        self.widths[0] + GAP + self.widths[1]
    }

    /// How many lines it has, titles among them.
    fn height(&self, ui: &egui::Ui) -> f32 {
        let rows = |line: &HelpLine| (text_width(ui, &line.inputs) / self.widths[1]).ceil();
        let group = |group: &&[HelpLine]| 2.0 + group.iter().map(rows).sum::<f32>();
        self.groups.iter().map(group).sum()
    }
}

/// The columns that show most: as many as fit, their inputs broken into lines if they don't and all
/// of them can be seen so; else what fits is scrolled.
fn fitting<'a>(ui: &egui::Ui, lines: &'a [HelpLine], room: Vec2) -> Vec<Column<'a>> {
    let whole = |columns: &[Column]| {
        let between = BETWEEN * (columns.len() as f32 - 1.0);
        columns.iter().map(Column::width).sum::<f32>() + between
    };
    let is_seen = |columns: &[Column]| {
        columns.iter().all(|column| column.height(ui) * (LETTERS + 4.0) <= room.y)
    };
    let made = |count: usize| -> Vec<Column> {
        let columns = columns(lines, count).into_iter();
        columns.map(|groups| Column::new(ui, groups)).collect()
    };
    let mut wide = None;
    for count in (1..=MOST_COLUMNS).rev() {
        let columns = made(count);
        if whole(&columns) <= room.x {
            if is_seen(&columns) {
                return columns;
            }
            wide = wide.or(Some(columns));
        }
    }
    for count in 2..=MOST_COLUMNS {
        let mut columns = made(count);
        let least = |column: &Column| column.widths[1].min(LEAST_INPUTS);
        let excess = whole(&columns) - room.x;
        let spare: f32 = columns.iter().map(|column| column.widths[1] - least(column)).sum();
        if excess > 0.0 && excess <= spare {
            for column in &mut columns {
                let part = (column.widths[1] - least(column)) / spare;
                column.widths[1] = (column.widths[1] - excess * part).floor();
            }
            if is_seen(&columns) {
                return columns;
            }
        }
    }
    wide.unwrap_or_else(|| {
        let mut columns = made(1);
        for Column { widths: [label, inputs], .. } in &mut columns {
            *label = label.min(0.45 * room.x);
            *inputs = inputs.min(room.x - GAP - *label);
        }
        columns
    })
}

/// Rounded up, so that a text fits into what was measured.
fn text_width(ui: &egui::Ui, text: &str) -> f32 {
    let text = egui::WidgetText::from(RichText::new(text).size(LETTERS));
    let galley = text.into_galley(ui, None, f32::INFINITY, egui::FontSelection::Default);
    galley.size().x.ceil() + 1.0
}

fn block(ui: &mut egui::Ui, group: &[HelpLine], [label, inputs]: [f32; 2]) {
    let Some(first) = group.first() else { return };
    ui.spacing_mut().item_spacing = vec2(GAP, 2.0);
    ui.label(RichText::new(first.group).color(ACCENT).size(LETTERS));
    for line in group {
        ui.horizontal_top(|ui| {
            for (text, colour, width) in
                [(line.label, WEAK, label), (line.inputs.as_str(), TEXT, inputs)]
            {
                let layout = egui::Layout::top_down(egui::Align::Min);
                ui.allocate_ui_with_layout(vec2(width, 18.0), layout, |ui| {
                    ui.set_width(width);
                    let text = RichText::new(text).color(colour).size(LETTERS);
                    ui.add(egui::Label::new(text).wrap());
                });
            }
        });
    }
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

    /// How visible it is, 0 to 1: not at all while what it speaks of is open.
    pub(crate) fn opacity(&self, settings: &PanelSettings, state: &PanelState) -> f32 {
        let shown = settings.hint && !state.menu && !state.help;
        if shown { (HINT - self.seconds).clamp(0.0, 1.0) } else { 0.0 }
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
