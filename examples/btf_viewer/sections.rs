//! The panel: what is shown, from its types; choices by the names of the configuration.

use bevy::prelude::*;
use farlight::{
    panel::{choice_row, egui::Ui},
    prelude::*,
};

use super::{
    material::{self, Materials},
    shown::Shown,
    state::Config,
};

/// What is known of the material.
#[derive(Resource, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Resource, Clone, Debug, Default, PartialEq)]
pub struct Facts {
    /// Texels along width and height.
    pub texels: String,
    /// Width and height of its picture on the object.
    pub picture: String,
    /// What its tables take on the graphics processor.
    pub memory: String,
    /// How long reading took.
    pub read_in: String,
}

/// Sections, in their order.
pub fn plugin(app: &mut App) {
    app.init_resource::<Facts>()
        .add_panel_section("Material", choose_material)
        .add_panel_part("Material", |shown: &mut Shown| &mut shown.material)
        .add_panel_status::<Facts>("Material")
        .add_panel_section("Object", choose_object)
        .add_panel_part("Object", |shown: &mut Shown| &mut shown.object)
        .add_panel_section("Light", choose_environment)
        .add_panel_part("Light", |shown: &mut Shown| &mut shown.light)
        .add_panel_part("Picture", |shown: &mut Shown| &mut shown.picture)
        .add_systems(Update, tell);
}

/// A choice by name; writes only what was chosen.
fn choose(
    ui: &mut Ui,
    world: &mut World,
    label: &str,
    names: &[String],
    now: usize,
    set: impl FnOnce(&mut Shown, usize),
) {
    if let Some(chosen) = choice_row(ui, label, names, now) {
        set(&mut world.resource_mut::<Shown>(), chosen);
    }
}

fn choose_material(ui: &mut Ui, world: &mut World) {
    let config = &world.resource::<Config>().0;
    let names: Vec<_> = config.materials.iter().map(|material| material.name.clone()).collect();
    let now = world.resource::<Shown>().material.choice;
    choose(ui, world, "Material", &names, now, |shown, i| shown.material.choice = i);
}

fn choose_object(ui: &mut Ui, world: &mut World) {
    let config = &world.resource::<Config>().0;
    let names: Vec<_> = config.models.iter().map(|model| model.name.clone()).collect();
    let now = world.resource::<Shown>().object.choice;
    choose(ui, world, "Object", &names, now, |shown, i| shown.object.choice = i);
}

fn choose_environment(ui: &mut Ui, world: &mut World) {
    let config = &world.resource::<Config>().0;
    let mut names: Vec<_> = config.environments.iter().map(|e| e.name.clone()).collect();
    let count = names.len();
    names.push("none".into());
    let now = world.resource::<Shown>().light.environment.unwrap_or(count);
    choose(ui, world, "Environment", &names, now, |shown, i| {
        shown.light.environment = (i < count).then_some(i);
    });
}

/// Tells what is known.
fn tell(
    config: Res<Config>,
    shown: Res<Shown>,
    materials: Res<Materials>,
    mut facts: ResMut<Facts>,
) {
    if !config.is_changed() && !shown.is_changed() && !materials.is_changed() {
        return;
    }
    let chosen = config.0.materials.get(shown.material.choice);
    let known = chosen.and_then(|chosen| Some((chosen, materials.about(chosen)?)));
    let new = known.map_or_else(Facts::default, |(chosen, about)| {
        let [width, height] = about.texels;
        let size = material::size(chosen, about) * shown.material.size * 1e3;
        Facts {
            texels: format!("{width} x {height}"),
            picture: format!("{:.0} x {:.0} mm", size.x, size.y),
            memory: format!("{:.1} MB", about.bytes as f32 * 1e-6),
            read_in: format!("{:.2} s", about.seconds),
        }
    });
    facts.set_if_neq(new);
}
