//! Actions and bindings as entities of `bevy_enhanced_input`.

use std::any::TypeId;

use bevy::prelude::*;
use bevy_enhanced_input::{context::input_reader::custom::CustomInputs, prelude::*};
use farlight_bindings::{ActionInfo, ActionKind, Context, Shape};

use crate::{
    actions::NamedAction,
    contexts::{GlobalContext, PanelContext, SceneContext},
    plugin::ControlsInForce,
    read::ActionEntities,
    sample::{Sampled, Sampling},
};

/// Adds actions to an app: those of a game beside the suite's.
pub trait AddAction {
    /// Adds an action; its bindings come from the file, under its name.
    fn add_action<A: NamedAction>(&mut self) -> &mut Self;
}

impl AddAction for App {
    fn add_action<A: NamedAction>(&mut self) -> &mut Self {
        let info = A::info();
        let world = self.world_mut();
        world.init_resource::<ActionEntities>();
        let entity = match info.context {
            Context::Scene => spawn::<A, SceneContext>(world),
            Context::Global => spawn::<A, GlobalContext>(world),
            Context::Panel => spawn::<A, PanelContext>(world),
        };
        let mut entities = world.resource_mut::<ActionEntities>();
        if entities.by_type.insert(TypeId::of::<A>(), entity).is_none() {
            entities.all.push((info, entity));
        }
        self
    }
}

/// The entity that has the contexts.
#[derive(Component)]
pub(crate) struct ControlsRoot;

fn root(world: &mut World) -> Entity {
    let mut roots = world.query_filtered::<Entity, With<ControlsRoot>>();
    roots.single(world).unwrap_or_else(|_| {
        let priorities = (
            ContextPriority::<SceneContext>::new(0),
            ContextPriority::<GlobalContext>::new(1),
            ContextPriority::<PanelContext>::new(2),
        );
        let contexts = (SceneContext, GlobalContext, PanelContext);
        let panel = ContextActivity::<PanelContext>::INACTIVE;
        world.spawn((ControlsRoot, Name::new("controls"), contexts, priorities, panel)).id()
    })
}

fn spawn<A: NamedAction, C: Component>(world: &mut World) -> Entity {
    let root = root(world);
    let name = Name::new(A::info().name);
    world.spawn((Action::<A>::new(), ActionOf::<C>::new(root), name)).id()
}

/// Makes the bindings' entities anew when the bindings in force have changed.
pub(crate) fn rebind(
    mut commands: Commands,
    in_force: Res<ControlsInForce>,
    entities: Res<ActionEntities>,
    mut custom: ResMut<CustomInputs>,
    mut sampling: ResMut<Sampling>,
    bound: Query<Entity, With<Binding>>,
) {
    if !in_force.is_changed() {
        return;
    }
    for entity in &bound {
        commands.entity(entity).despawn();
    }
    sampling.sampled.clear();
    for device in farlight_bindings::Device::ALL {
        for (info, action) in &entities.all {
            for binding in in_force.bindings.of(info.name, device) {
                let id = custom.register_input();
                commands.spawn((Binding::Custom(id), BindingOf(*action))).insert(modifiers(
                    &binding,
                    info,
                    &in_force.bindings,
                ));
                sampling.sampled.push(Sampled { id, device, info: *info, binding });
            }
        }
    }
}

/// How `bevy_enhanced_input` treats a binding's values.
fn modifiers(
    binding: &farlight_bindings::Binding,
    info: &ActionInfo,
    _settings: &farlight_bindings::Bindings,
) -> impl Bundle {
    let held = binding
        .source
        .inputs()
        .iter()
        .all(|input| matches!(input.shape(), Shape::Button | Shape::Analog | Shape::Stick));
    let rate = held && info.kind != ActionKind::Button;
    let _ = rate;
    Scale::splat(binding.scale)
}
