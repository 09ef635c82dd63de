//! What panels show.

use std::sync::{Arc, Mutex};

use bevy::{ecs::component::Mutable, prelude::*, reflect::Typed};
use bevy_egui::egui::Ui;
use farlight_core::field::Costly;

use crate::fields::{Fields, Spec, choice, edit, row, show, switch};

type Draw = Arc<dyn Fn(&mut Ui, &mut World) + Send + Sync>;

/// Parts under one title.
#[derive(Clone)]
pub(crate) struct Section {
    pub(crate) title: &'static str,
    parts: Vec<Draw>,
}

impl Section {
    /// Draws all parts.
    pub(crate) fn draw(&self, ui: &mut Ui, world: &mut World) {
        for (at, part) in self.parts.iter().enumerate() {
            ui.push_id(at, |ui| part(ui, world));
        }
    }
}

/// All sections, in order.
#[derive(Resource, Default)]
pub(crate) struct Sections(pub(crate) Vec<Section>);

/// Adds settings to the panel. What is added under the title of a section that exists goes below
/// what it has.
pub trait AddPanel {
    /// Shows a reflected resource: its fields as switches, sliders, choices. It counts as changed only
    /// when somebody changes it. Where the app has no such resource, nothing is shown.
    ///
    /// What fields say of themselves is in [`farlight_core::field`]; doc comments become tooltips.
    fn add_panel_resource<T>(&mut self, title: &'static str) -> &mut Self
    where
        T: Resource + Component<Mutability = Mutable> + Reflect + Typed;

    /// Shows a reflected resource that only its plugin writes.
    fn add_panel_status<T: Resource + Component<Mutability = Mutable> + Reflect>(
        &mut self,
        title: &'static str,
    ) -> &mut Self;

    /// Shows a reflected component of the entities that have it and `F`: the first eight of them,
    /// under their names if there are several. Read only if `F` comes with `change` off.
    fn add_panel_component<T, F>(&mut self, title: &'static str, change: bool) -> &mut Self
    where
        T: Component<Mutability = Mutable> + Reflect,
        F: bevy::ecs::query::QueryFilter + 'static;

    /// Shows a reflected part of a resource.
    fn add_panel_part<T, P>(
        &mut self,
        title: &'static str,
        part: fn(&mut T) -> &mut P,
    ) -> &mut Self
    where
        T: Resource + Component<Mutability = Mutable>,
        P: PartialReflect;

    /// Shows whatever `draw` draws, by [`egui`](crate::egui). It runs once for each picture of the
    /// panel while its section is unfolded.
    fn add_panel_section(
        &mut self,
        title: &'static str,
        draw: impl Fn(&mut Ui, &mut World) + Send + Sync + 'static,
    ) -> &mut Self;
}

impl AddPanel for App {
    fn add_panel_resource<T>(&mut self, title: &'static str) -> &mut Self
    where
        T: Resource + Component<Mutability = Mutable> + Reflect + Typed,
    {
        let costly = is_costly(T::type_info());
        let draft = Arc::new(Mutex::new(None::<T>));
        self.add_panel_section(title, move |ui, world| {
            let registry = world.resource::<AppTypeRegistry>().clone();
            let registry = registry.read();
            let fields = Fields { registry: &registry, read_only: false };
            let Some(mut value) = world.get_resource_mut::<T>() else { return };
            if costly {
                let mut draft = draft.lock().unwrap_or_else(|e| e.into_inner());
                later(ui, &fields, &mut value, &mut draft);
            } else if fields.root(ui, value.bypass_change_detection().as_partial_reflect_mut()) {
                value.set_changed();
            }
        })
    }

    fn add_panel_status<T: Resource + Component<Mutability = Mutable> + Reflect>(
        &mut self,
        title: &'static str,
    ) -> &mut Self {
        self.add_panel_section(title, |ui, world| {
            let registry = world.resource::<AppTypeRegistry>().clone();
            let registry = registry.read();
            let fields = Fields { registry: &registry, read_only: true };
            if let Some(mut value) = world.get_resource_mut::<T>() {
                fields.root(ui, value.bypass_change_detection().as_partial_reflect_mut());
            }
        })
    }

    fn add_panel_component<T, F>(&mut self, title: &'static str, change: bool) -> &mut Self
    where
        T: Component<Mutability = Mutable> + Reflect,
        F: bevy::ecs::query::QueryFilter + 'static,
    {
        self.add_panel_section(title, move |ui, world| {
            let registry = world.resource::<AppTypeRegistry>().clone();
            let registry = registry.read();
            let fields = Fields { registry: &registry, read_only: !change };
            let mut entities = world.query_filtered::<(Entity, &mut T, Option<&Name>), F>();
            let several = entities.iter(world).nth(1).is_some();
            for (entity, mut value, name) in entities.iter_mut(world).take(8) {
                if several {
                    let name = name.map_or_else(|| entity.to_string(), ToString::to_string);
                    ui.strong(name);
                }
                let value_mut = value.bypass_change_detection().as_partial_reflect_mut();
                if ui.push_id(entity, |ui| fields.root(ui, value_mut)).inner {
                    value.set_changed();
                }
            }
        })
    }

    fn add_panel_part<T, P>(&mut self, title: &'static str, part: fn(&mut T) -> &mut P) -> &mut Self
    where
        T: Resource + Component<Mutability = Mutable>,
        P: PartialReflect,
    {
        self.add_panel_section(title, move |ui, world| {
            let registry = world.resource::<AppTypeRegistry>().clone();
            let registry = registry.read();
            let fields = Fields { registry: &registry, read_only: false };
            let Some(mut value) = world.get_resource_mut::<T>() else { return };
            if fields.root(ui, part(value.bypass_change_detection()).as_partial_reflect_mut()) {
                value.set_changed();
            }
        })
    }

    fn add_panel_section(
        &mut self,
        title: &'static str,
        draw: impl Fn(&mut Ui, &mut World) + Send + Sync + 'static,
    ) -> &mut Self {
        let mut sections = self.world_mut().get_resource_or_init::<Sections>();
        let draw: Draw = Arc::new(draw);
        match sections.0.iter_mut().find(|section| section.title == title) {
            Some(section) => section.parts.push(draw),
            None => sections.0.push(Section { title, parts: vec![draw] }),
        }
        self
    }
}

fn is_costly(info: &bevy::reflect::TypeInfo) -> bool {
    use bevy::reflect::TypeInfo;
    match info {
        TypeInfo::Struct(info) => info.has_attribute::<Costly>(),
        TypeInfo::Enum(info) => info.has_attribute::<Costly>(),
        TypeInfo::TupleStruct(info) => info.has_attribute::<Costly>(),
        _ => false,
    }
}

/// Changes a copy, and the resource when nothing is held any more.
fn later<T: Resource + Component<Mutability = Mutable> + Reflect>(
    ui: &mut Ui,
    fields: &Fields,
    value: &mut Mut<T>,
    draft: &mut Option<T>,
) {
    let mut edited = match draft.take() {
        Some(draft) => draft,
        None => match value.reflect_clone().map(|copy| copy.take::<T>()) {
            Ok(Ok(copy)) => copy,
            // What can't be copied is changed in place.
            _ => {
                let direct = value.bypass_change_detection().as_partial_reflect_mut();
                if fields.root(ui, direct) {
                    value.set_changed();
                }
                return;
            }
        },
    };
    fields.root(ui, edited.as_partial_reflect_mut());
    let same = edited.reflect_partial_eq(value.as_partial_reflect()).unwrap_or(false);
    if same {
        return;
    }
    if ui.input(|input| input.pointer.any_down()) {
        *draft = Some(edited);
    } else {
        **value = edited;
    }
}

/// A choice of a game's own in a section: a label, and one of `names`, of which `now` is chosen. What
/// somebody chose instead, if they did.
pub fn choice_row(ui: &mut Ui, label: &str, names: &[String], now: usize) -> Option<usize> {
    row(ui, label, None, |ui| choice(ui, names, now))
}

/// A line of a game's own in a section that is only read: a label and a text.
pub fn text_row(ui: &mut Ui, label: &str, text: impl Into<String>) {
    row(ui, label, None, |ui| show(ui, text));
}

/// A switch of a game's own in a section; true if somebody switched it.
pub fn switch_row(ui: &mut Ui, label: &str, on: &mut bool) -> bool {
    row(ui, label, None, |ui| switch(ui, on))
}

/// A slider of a game's own in a section; true if somebody moved it. Over three decades or more it
/// goes by factors.
pub fn slider_row(
    ui: &mut Ui,
    label: &str,
    value: &mut f32,
    range: std::ops::RangeInclusive<f32>,
    unit: &'static str,
) -> bool {
    let range = f64::from(*range.start())..=f64::from(*range.end());
    let spec = Spec { range: Some(range), unit, ..Default::default() };
    let mut edited = f64::from(*value);
    let changed = row(ui, label, None, |ui| edit(ui, &mut edited, &spec));
    if changed {
        *value = edited as f32;
    }
    changed
}

/// A button of a game's own in a section: a label, and on the button a text. True if it was pressed.
pub fn button_row(ui: &mut Ui, label: &str, text: impl Into<String>) -> bool {
    row(ui, label, None, |ui| {
        let size = bevy_egui::egui::vec2(ui.available_width(), ui.spacing().interact_size.y - 2.0);
        let text: String = text.into();
        ui.add_sized(size, bevy_egui::egui::Button::new(text).truncate()).clicked()
    })
}
