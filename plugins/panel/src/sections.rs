//! What panels show.

use bevy::prelude::*;

/// A resource that a panel shows.
#[derive(Clone)]
#[expect(dead_code, reason = "drawn by the next step")]
pub(crate) struct Section {
    pub(crate) title: &'static str,
    pub(crate) type_id: std::any::TypeId,
}

/// All sections, in order.
#[derive(Resource, Default)]
pub(crate) struct Sections(pub(crate) Vec<Section>);

/// Adds settings to the panel.
pub trait AddPanel {
    /// Shows a reflected resource under a title.
    fn add_panel_resource<T: Resource + Reflect + TypePath>(
        &mut self,
        title: &'static str,
    ) -> &mut Self;
}

impl AddPanel for App {
    fn add_panel_resource<T: Resource + Reflect + TypePath>(
        &mut self,
        title: &'static str,
    ) -> &mut Self {
        let mut sections = self.world_mut().get_resource_or_init::<Sections>();
        sections.0.push(Section { title, type_id: std::any::TypeId::of::<T>() });
        self
    }
}
