//! Enums: a choice, and the fields of what is chosen.

use bevy::{
    prelude::*,
    reflect::{
        PartialReflect, ReflectMut, TypeInfo,
        enums::{DynamicEnum, DynamicVariant, EnumInfo, VariantInfo},
        structs::DynamicStruct,
        tuple::DynamicTuple,
    },
};
use bevy_egui::egui::Ui;

use super::{About, Fields, choice, row, show, switch, words};

impl Fields<'_> {
    /// A choice between the variants, and the fields of the chosen one below it.
    pub(super) fn variants(
        &self,
        ui: &mut Ui,
        label: &str,
        about: About<'_>,
        value: &mut dyn PartialReflect,
    ) -> bool {
        let Some(TypeInfo::Enum(info)) = value.get_represented_type_info() else { return false };
        if info.type_path().starts_with("core::option::Option<") {
            return self.option(ui, label, about, info, value);
        }
        let ReflectMut::Enum(current) = value.reflect_mut() else { return false };
        let chosen = current.variant_index();
        let names: Vec<_> = info.variant_names().iter().map(|name| words(name)).collect();
        let docs = about.docs.or_else(|| info.variant_at(chosen).and_then(VariantInfo::docs));
        let next = row(ui, label, docs, |ui| {
            if self.read_only {
                show(ui, names.get(chosen).cloned().unwrap_or_default());
                None
            } else {
                choice(ui, &names, chosen)
            }
        });
        if let Some(variant) = next.and_then(|next| info.variant_at(next))
            && self.switch_to(value, variant)
        {
            return true;
        }
        self.variant_fields(ui, info, value)
    }

    fn variant_fields(&self, ui: &mut Ui, info: &EnumInfo, value: &mut dyn PartialReflect) -> bool {
        let ReflectMut::Enum(current) = value.reflect_mut() else { return false };
        if current.field_len() == 0 {
            return false;
        }
        let variant = info.variant_at(current.variant_index());
        ui.indent(current.variant_index(), |ui| {
            let mut changed = false;
            for at in 0..current.field_len() {
                let (name, about) = match variant {
                    Some(VariantInfo::Struct(fields)) => {
                        let field = fields.field_at(at);
                        (words(field.map_or("", |field| field.name())), About::named(field))
                    }
                    Some(VariantInfo::Tuple(fields)) => {
                        let name = if current.field_len() == 1 { "Value" } else { "" };
                        let name = match name {
                            "" => (at + 1).to_string(),
                            name => name.to_string(),
                        };
                        (name, About::unnamed(fields.field_at(at)))
                    }
                    _ => (String::new(), About::default()),
                };
                if let Some(field) = current.field_at_mut(at) {
                    changed |= ui.push_id(at, |ui| self.field(ui, &name, about, field)).inner;
                }
            }
            changed
        })
        .inner
    }

    /// A switch, and the value below it.
    fn option(
        &self,
        ui: &mut Ui,
        label: &str,
        about: About<'_>,
        info: &EnumInfo,
        value: &mut dyn PartialReflect,
    ) -> bool {
        let ReflectMut::Enum(current) = value.reflect_mut() else { return false };
        let mut some = current.variant_name() == "Some";
        let inner = info.variant("Some").and_then(|some| match some {
            VariantInfo::Tuple(fields) => fields.field_at(0),
            _ => None,
        });
        // What has no default can't be made here; handles of assets least of all.
        let can_be_made = inner.is_some_and(|field| self.default_of(field.type_id()).is_some());
        if self.read_only || !can_be_made {
            return match current.field_at_mut(0) {
                Some(field) => self.field(ui, label, about, field),
                None => false,
            };
        }
        let switched = row(ui, label, about.docs, |ui| switch(ui, &mut some));
        if switched {
            let variant = info.variant(if some { "Some" } else { "None" });
            return variant.is_some_and(|variant| self.switch_to(value, variant));
        }
        let ReflectMut::Enum(current) = value.reflect_mut() else { return false };
        match current.field_at_mut(0) {
            Some(field) => {
                let inside = About { docs: None, ..about };
                ui.indent(label, |ui| self.field(ui, "Value", inside, field)).inner
            }
            None => false,
        }
    }

    /// Makes it another variant, whose fields have their defaults.
    fn switch_to(&self, value: &mut dyn PartialReflect, variant: &VariantInfo) -> bool {
        let fields = match variant {
            VariantInfo::Unit(_) => Some(DynamicVariant::Unit),
            VariantInfo::Tuple(fields) => {
                let mut tuple = DynamicTuple::default();
                fields
                    .iter()
                    .try_for_each(|field| {
                        tuple
                            .insert_boxed(self.default_of(field.type_id())?.into_partial_reflect());
                        Some(())
                    })
                    .map(|()| DynamicVariant::Tuple(tuple))
            }
            VariantInfo::Struct(fields) => {
                let mut made = DynamicStruct::default();
                fields
                    .iter()
                    .try_for_each(|field| {
                        let default = self.default_of(field.type_id())?.into_partial_reflect();
                        made.insert_boxed(field.name(), default);
                        Some(())
                    })
                    .map(|()| DynamicVariant::Struct(made))
            }
        };
        fields.is_some_and(|fields| {
            value.try_apply(&DynamicEnum::new(variant.name(), fields)).is_ok()
        })
    }

    fn default_of(&self, type_id: std::any::TypeId) -> Option<Box<dyn Reflect>> {
        Some(self.registry.get_type_data::<ReflectDefault>(type_id)?.default())
    }
}
