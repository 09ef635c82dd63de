//! One look for all panels: dark slate, light text, one warm accent.

use bevy_egui::egui::{
    Color32, Context, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Vec2, Visuals,
    style::{HandleShape, WidgetVisuals},
};

/// Of panels.
pub(crate) const SLATE: Color32 = Color32::from_rgb(21, 24, 29);
/// Of what can be pressed.
pub(crate) const RAISED: Color32 = Color32::from_rgb(43, 48, 57);
/// Of it where the pointer is.
pub(crate) const HOVERED: Color32 = Color32::from_rgb(60, 67, 79);
/// Of lines.
pub(crate) const LINE: Color32 = Color32::from_rgb(54, 60, 70);
/// Of text.
pub(crate) const TEXT: Color32 = Color32::from_rgb(232, 234, 237);
/// Of labels and units.
pub(crate) const WEAK: Color32 = Color32::from_rgb(190, 196, 206);
/// What is on, focused, chosen.
pub(crate) const ACCENT: Color32 = Color32::from_rgb(245, 184, 92);
/// What failed.
pub(crate) const PROBLEM: Color32 = Color32::from_rgb(255, 122, 107);

/// Height of a row of a panel in points.
pub(crate) const ROW: f32 = 24.0;

/// Makes a context look like it.
pub(crate) fn apply(ctx: &Context) {
    ctx.set_theme(bevy_egui::egui::Theme::Dark);
    ctx.all_styles_mut(|style| {
        style.text_styles = [
            (TextStyle::Small, 11.5),
            (TextStyle::Body, 14.0),
            (TextStyle::Button, 14.0),
            (TextStyle::Heading, 18.0),
        ]
        .map(|(name, size)| (name, FontId::new(size, FontFamily::Proportional)))
        .into_iter()
        .chain([(TextStyle::Monospace, FontId::new(12.5, FontFamily::Monospace))])
        .collect();
        style.spacing.item_spacing = Vec2::new(8.0, 4.0);
        style.spacing.button_padding = Vec2::new(10.0, 3.0);
        style.spacing.interact_size = Vec2::new(40.0, ROW);
        style.spacing.indent = 14.0;
        style.spacing.window_margin = Margin::same(14);
        style.spacing.tooltip_width = 300.0;
        style.spacing.scroll.floating = true;
        style.interaction.selectable_labels = false;
        style.interaction.tooltip_delay = 0.6;
        style.animation_time = 0.1;
        style.visuals = visuals();
    });
}

fn visuals() -> Visuals {
    let widget = |fill: Color32, line: Color32, text: Color32| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, line),
        corner_radius: CornerRadius::same(5),
        fg_stroke: Stroke::new(1.0, text),
        expansion: 0.0,
    };
    let mut visuals = Visuals::dark();
    visuals.widgets.noninteractive = widget(SLATE, LINE, TEXT);
    visuals.widgets.inactive = widget(RAISED, Color32::TRANSPARENT, TEXT);
    visuals.widgets.hovered = widget(HOVERED, Color32::TRANSPARENT, Color32::WHITE);
    visuals.widgets.active = widget(HOVERED, Color32::TRANSPARENT, Color32::WHITE);
    visuals.widgets.open = widget(HOVERED, Color32::TRANSPARENT, TEXT);
    visuals.selection.bg_fill = ACCENT.gamma_multiply(0.45);
    visuals.selection.stroke = Stroke::new(1.0, ACCENT);
    visuals.hyperlink_color = ACCENT;
    visuals.window_fill = SLATE;
    visuals.panel_fill = SLATE;
    visuals.extreme_bg_color = Color32::from_rgb(12, 14, 17);
    visuals.faint_bg_color = Color32::from_rgb(28, 32, 38);
    visuals.weak_text_color = Some(WEAK);
    visuals.window_corner_radius = CornerRadius::same(10);
    visuals.menu_corner_radius = CornerRadius::same(8);
    visuals.window_stroke = Stroke::new(1.0, LINE);
    visuals.window_shadow = Default::default();
    visuals.popup_shadow = Default::default();
    visuals.slider_trailing_fill = true;
    visuals.handle_shape = HandleShape::Circle;
    visuals.indent_has_left_vline = false;
    visuals.warn_fg_color = ACCENT;
    visuals.error_fg_color = PROBLEM;
    visuals
}
