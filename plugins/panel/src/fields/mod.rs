//! Widgets from reflected types: no list of widgets is kept by hand.

mod about;
mod choice;
mod number;
mod variant;

use std::{borrow::Cow, ops::RangeInclusive, sync::Arc, time::Duration};

use bevy::{
    prelude::*,
    reflect::{PartialReflect, ReflectMut, TypeInfo, TypeRegistry},
};
use bevy_egui::egui::{self, RichText, Ui};
use farlight_core::{
    TimeWindow,
    field::{Hidden, Label, ReadOnly, Turn},
};

use about::plain;
pub(crate) use about::{About, words};
pub(crate) use choice::{choice, switch};
pub(crate) use number::{Spec, edit, show};

use crate::{plot, style::WEAK};

/// Elements of a list that are shown; status lists have no bound.
const LONGEST_LIST: usize = 12;

/// What every field needs.
#[derive(Clone, Copy)]
pub(crate) struct Fields<'a> {
    pub(crate) registry: &'a TypeRegistry,
    pub(crate) read_only: bool,
}

/// A row: what it is on the left, what can be done on the right.
pub(crate) fn row<R>(
    ui: &mut Ui,
    label: &str,
    docs: Option<&str>,
    add: impl FnOnce(&mut Ui) -> R,
) -> R {
    let height = ui.spacing().interact_size.y;
    ui.horizontal(|ui| {
        // Labels of groups are further to the right; controls stay in line.
        let whole = ui.ctx().data(|data| data.get_temp(egui::Id::new(WIDTH))).unwrap_or(320.0);
        let width = (ui.available_width() - whole * CONTROLS).max(60.0);
        let size = egui::vec2(width, height);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_size(size);
            let text = RichText::new(label).color(WEAK);
            let response = ui.add(egui::Label::new(text).truncate());
            if let Some(docs) = docs {
                response.on_hover_text(plain(docs));
            }
        });
        add(ui)
    })
    .inner
}

/// Where the width of a section is kept, so that controls of all depths are in line.
pub(crate) const WIDTH: &str = "farlight panel width";
/// The part of it that controls have.
const CONTROLS: f32 = 0.58;

impl Fields<'_> {
    /// A whole resource or component; true if it was changed.
    pub(crate) fn root(&self, ui: &mut Ui, value: &mut dyn PartialReflect) -> bool {
        let info = value.get_represented_type_info();
        match value.reflect_mut() {
            ReflectMut::Struct(_) | ReflectMut::TupleStruct(_) => self.inside(ui, value),
            _ => {
                let attributes = info.and_then(|info| match info {
                    TypeInfo::Enum(info) => Some(info.custom_attributes()),
                    _ => None,
                });
                let about = About { attributes, docs: info.and_then(TypeInfo::docs) };
                let name = info.map_or("", |info| info.type_path_table().ident().unwrap_or(""));
                self.field(ui, &words(name), about, value)
            }
        }
    }

    /// One field.
    pub(crate) fn field(
        &self,
        ui: &mut Ui,
        name: &str,
        about: About<'_>,
        value: &mut dyn PartialReflect,
    ) -> bool {
        if about.has::<Hidden>() {
            return false;
        }
        let label = about.get::<Label>().map_or(name, |label| label.0);
        let read_only = self.read_only || about.has::<ReadOnly>();
        let fields = Self { read_only, ..*self };
        if let Some(changed) = fields.leaf(ui, label, about, value) {
            return changed;
        }
        match value.reflect_mut() {
            ReflectMut::Enum(_) => fields.variants(ui, label, about, value),
            ReflectMut::Struct(s) if s.field_len() > 0 => fields.group(ui, label, about, value),
            // A newtype is what it wraps.
            ReflectMut::TupleStruct(tuple) if tuple.field_len() == 1 => {
                tuple.field_mut(0).is_some_and(|inner| fields.field(ui, label, about, inner))
            }
            ReflectMut::TupleStruct(_) | ReflectMut::Tuple(_) => {
                fields.group(ui, label, about, value)
            }
            ReflectMut::List(list) if !list.is_empty() => fields.group(ui, label, about, value),
            ReflectMut::Array(array) if !array.is_empty() => fields.group(ui, label, about, value),
            // Handles, maps and what else has no widget.
            _ => false,
        }
    }

    /// Values that have a widget of their own.
    fn leaf(
        &self,
        ui: &mut Ui,
        label: &str,
        about: About<'_>,
        value: &mut dyn PartialReflect,
    ) -> Option<bool> {
        let docs = about.docs;
        macro_rules! numbers {
            ($integer:literal: $($number:ident)*) => {$(
                if let Some(number) = value.try_downcast_mut::<$number>() {
                    let range = about.get::<RangeInclusive<$number>>();
                    let range = range.map(|range| *range.start() as f64..=*range.end() as f64);
                    let spec = about.spec(range, $integer);
                    let mut edited = *number as f64;
                    if !self.number(ui, label, docs, &mut edited, &spec) {
                        return Some(false);
                    }
                    let edited = edited as $number;
                    let changed = edited != *number;
                    *number = edited;
                    return Some(changed);
                }
            )*};
        }
        numbers!(false: f32 f64);
        numbers!(true: u32 usize u64 i32 u8 u16 i64 i8 i16 isize);
        if let Some(on) = value.try_downcast_mut::<bool>() {
            return Some(row(ui, label, docs, |ui| {
                if self.read_only {
                    show(ui, if *on { "yes" } else { "no" });
                    false
                } else {
                    switch(ui, on)
                }
            }));
        }
        if let Some(text) = value.try_downcast_mut::<String>() {
            return Some(row(ui, label, docs, |ui| {
                if self.read_only {
                    show(ui, text.clone());
                    false
                } else {
                    let width = ui.available_width();
                    ui.add(egui::TextEdit::singleline(text).desired_width(width)).changed()
                }
            }));
        }
        if let Some(window) = value.try_downcast_ref::<TimeWindow>() {
            plot::times(ui, label, docs, window);
            return Some(false);
        }
        if let Some(text) = text(value) {
            row(ui, label, docs, |ui| show(ui, text));
            return Some(false);
        }
        if let Some(turn) = value.try_downcast_mut::<Quat>() {
            let spec = Spec { range: Some(-180.0..=180.0), unit: "°", ..default() };
            let (yaw, ..) = turn.to_euler(EulerRot::YXZ);
            let mut degrees = f64::from(yaw.to_degrees());
            if !about.has::<Turn>() || !self.number(ui, label, docs, &mut degrees, &spec) {
                return Some(false);
            }
            let by = (degrees as f32).to_radians() - yaw;
            *turn = (Quat::from_rotation_y(by) * *turn).normalize();
            return Some(true);
        }
        if let Some(changed) = self.colour(ui, label, docs, value) {
            return Some(changed);
        }
        // Vectors: their axes below each other would be long; all in one row.
        macro_rules! vectors {
            ($($vector:ident $axis:ident $integer:literal),*) => {$(
                if let Some(vector) = value.try_downcast_mut::<$vector>() {
                    let before = *vector;
                    let mut axes = vector.to_array().map(|axis| axis as f64);
                    self.vector(ui, label, docs, &mut axes, &about.spec(None, $integer));
                    *vector = $vector::from_array(axes.map(|axis| axis as $axis));
                    return Some(*vector != before);
                }
            )*};
        }
        vectors!(Vec2 f32 false, Vec3 f32 false, Vec4 f32 false, UVec2 u32 true, UVec3 u32 true,
            IVec2 i32 true, IVec3 i32 true);
        None
    }

    fn number(
        &self,
        ui: &mut Ui,
        label: &str,
        docs: Option<&str>,
        value: &mut f64,
        spec: &Spec,
    ) -> bool {
        row(ui, label, docs, |ui| {
            if self.read_only {
                show(ui, spec.text(*value));
                false
            } else {
                edit(ui, value, spec)
            }
        })
    }

    fn vector(&self, ui: &mut Ui, label: &str, docs: Option<&str>, axes: &mut [f64], spec: &Spec) {
        row(ui, label, docs, |ui| {
            if self.read_only {
                let axes: Vec<_> = axes.iter().map(|axis| spec.text(*axis)).collect();
                show(ui, axes.join("  "));
                return;
            }
            let count = axes.len() as f32;
            let width = (ui.available_width() - 4.0 * (count - 1.0)) / count;
            ui.spacing_mut().item_spacing.x = 4.0;
            for axis in axes {
                let drag = egui::DragValue::new(axis).speed(if spec.integer { 0.2 } else { 0.01 });
                let drag = drag.max_decimals(if spec.integer { 0 } else { 3 });
                ui.add_sized([width, ui.spacing().interact_size.y], drag);
            }
        });
    }

    fn colour(
        &self,
        ui: &mut Ui,
        label: &str,
        docs: Option<&str>,
        value: &mut dyn PartialReflect,
    ) -> Option<bool> {
        let before: Srgba = if let Some(colour) = value.try_downcast_ref::<Color>() {
            colour.to_srgba()
        } else if let Some(colour) = value.try_downcast_ref::<LinearRgba>() {
            (*colour).into()
        } else {
            *value.try_downcast_ref::<Srgba>()?
        };
        let mut rgb =
            before.to_f32_array_no_alpha().map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
        let changed = row(ui, label, docs, |ui| {
            ui.add_enabled_ui(!self.read_only, |ui| ui.color_edit_button_srgb(&mut rgb).changed())
                .inner
        });
        if changed {
            let new = Srgba { alpha: before.alpha, ..Srgba::rgb_u8(rgb[0], rgb[1], rgb[2]) };
            if let Some(colour) = value.try_downcast_mut::<Color>() {
                *colour = new.into();
            } else if let Some(colour) = value.try_downcast_mut::<LinearRgba>() {
                *colour = new.into();
            } else if let Some(colour) = value.try_downcast_mut::<Srgba>() {
                *colour = new;
            }
        }
        Some(changed)
    }

    /// A foldable group with the fields of a value.
    fn group(
        &self,
        ui: &mut Ui,
        label: &str,
        about: About<'_>,
        value: &mut dyn PartialReflect,
    ) -> bool {
        let header = egui::CollapsingHeader::new(RichText::new(label).color(WEAK)).id_salt(label);
        let shown = header.show(ui, |ui| self.inside(ui, value));
        if let Some(docs) = about.docs {
            shown.header_response.on_hover_text(plain(docs));
        }
        shown.body_returned.unwrap_or(false)
    }

    /// The fields of a value, without a heading.
    fn inside(&self, ui: &mut Ui, value: &mut dyn PartialReflect) -> bool {
        let info = value.get_represented_type_info();
        let mut changed = false;
        match value.reflect_mut() {
            ReflectMut::Struct(fields) => {
                let info = info.and_then(|info| info.as_struct().ok());
                for at in 0..fields.field_len() {
                    let about = About::named(info.and_then(|info| info.field_at(at)));
                    let name = words(fields.name_at(at).unwrap_or_default());
                    if let Some(field) = fields.field_at_mut(at) {
                        changed |= ui.push_id(at, |ui| self.field(ui, &name, about, field)).inner;
                    }
                }
            }
            ReflectMut::TupleStruct(fields) => {
                let info = info.and_then(|info| info.as_tuple_struct().ok());
                for at in 0..fields.field_len() {
                    let about = About::unnamed(info.and_then(|info| info.field_at(at)));
                    if let Some(field) = fields.field_mut(at) {
                        let name = (at + 1).to_string();
                        changed |= ui.push_id(at, |ui| self.field(ui, &name, about, field)).inner;
                    }
                }
            }
            ReflectMut::Tuple(fields) => {
                for at in 0..fields.field_len() {
                    changed |= fields.field_mut(at).is_some_and(|f| self.element(ui, at, f));
                }
            }
            ReflectMut::List(list) => {
                for at in 0..list.len().min(LONGEST_LIST) {
                    changed |= list.get_mut(at).is_some_and(|f| self.element(ui, at, f));
                }
                if list.len() > LONGEST_LIST {
                    ui.weak(format!("and {} more", list.len() - LONGEST_LIST));
                }
            }
            ReflectMut::Array(array) => {
                for at in 0..array.len().min(LONGEST_LIST) {
                    changed |= array.get_mut(at).is_some_and(|f| self.element(ui, at, f));
                }
            }
            _ => {}
        }
        changed
    }

    fn element(&self, ui: &mut Ui, at: usize, value: &mut dyn PartialReflect) -> bool {
        let name = (at + 1).to_string();
        ui.push_id(at, |ui| self.field(ui, &name, About::default(), value)).inner
    }
}

/// Values that are shown as a text and not changed.
fn text(value: &dyn PartialReflect) -> Option<String> {
    if let Some(text) = value.try_downcast_ref::<Cow<'static, str>>() {
        return Some(text.to_string());
    }
    if let Some(text) = value.try_downcast_ref::<&'static str>() {
        return Some((*text).to_string());
    }
    if let Some(text) = value.try_downcast_ref::<Arc<str>>() {
        return Some(text.to_string());
    }
    if let Some(time) = value.try_downcast_ref::<Duration>() {
        return Some(plot::time_text(*time));
    }
    value.try_downcast_ref::<Entity>().map(|entity| entity.to_string())
}
