//! Actions as entities of `bevy_enhanced_input`.

use std::any::TypeId;

use bevy::prelude::*;
use bevy_enhanced_input::{context::input_reader::custom::CustomInputs, prelude::*};
use farlight_bindings::Context;

use crate::{
    actions::NamedAction,
    contexts::{GlobalContext, PanelContext, SceneContext},
    read::{ActionEntities, ActionEntity},
};

/// Adds actions to an app: those of a game beside the suite's.
pub trait AddAction {
    /// Adds an action; its bindings come from the file, under its name. A second call does nothing.
    fn add_action<A: NamedAction>(&mut self) -> &mut Self;
}

impl AddAction for App {
    fn add_action<A: NamedAction>(&mut self) -> &mut Self {
        let info = A::info();
        let world = self.world_mut();
        let known = world.get_resource_or_init::<ActionEntities>();
        if known.by_type.contains_key(&TypeId::of::<A>()) {
            return self;
        }
        if known.all.iter().any(|action| action.info.name == info.name) {
            warn!("two actions are called {}: the second is left out", info.name);
            return self;
        }
        let input = world.get_resource_or_init::<CustomInputs>().register_input();
        let entity = match info.context {
            Context::Scene => spawn::<A, SceneContext>(world),
            Context::Global => spawn::<A, GlobalContext>(world),
            Context::Panel => spawn::<A, PanelContext>(world),
        };
        // What is bound changes; what the engine hears doesn't: one input of ours for each action.
        world.spawn((Binding::Custom(input), BindingOf(entity)));
        let mut entities = world.resource_mut::<ActionEntities>();
        entities.by_type.insert(TypeId::of::<A>(), entity);
        entities.all.push(ActionEntity { info, entity, input });
        self
    }
}

/// The entity that has the contexts.
#[derive(Component)]
pub(crate) struct ControlsRoot;

fn root(world: &mut World) -> Entity {
    let mut roots = world.query_filtered::<Entity, With<ControlsRoot>>();
    let root = roots.single(world);
    root.unwrap_or_else(|_| world.spawn((ControlsRoot, Name::new("controls"))).id())
}

/// Gives contexts to the entity that has them: `bevy_enhanced_input` knows them when the app is finished.
pub(crate) fn add_contexts(world: &mut World) {
    let root = root(world);
    world.entity_mut(root).insert((
        (SceneContext, GlobalContext, PanelContext),
        ContextPriority::<SceneContext>::new(0),
        ContextPriority::<GlobalContext>::new(1),
        ContextPriority::<PanelContext>::new(2),
        ContextActivity::<PanelContext>::INACTIVE,
    ));
}

fn spawn<A: NamedAction, C: Component>(world: &mut World) -> Entity {
    let root = root(world);
    let name = Name::new(A::info().name);
    world.spawn((Action::<A>::new(), ActionOf::<C>::new(root), name)).id()
}
