//! Reading actions.

use std::any::TypeId;

use bevy::{ecs::system::SystemParam, platform::collections::HashMap, prelude::*};
use bevy_enhanced_input::{context::input_reader::custom::CustomInput, prelude::*};
use farlight_bindings::{ActionInfo, ActionKind};

use crate::actions::NamedAction;

/// The entities of actions.
#[derive(Resource, Default)]
pub(crate) struct ActionEntities {
    pub(crate) by_type: HashMap<TypeId, Entity>,
    /// In the order in which they were added.
    pub(crate) all: Vec<ActionEntity>,
}

/// An action of the app.
#[derive(Clone, Copy)]
pub(crate) struct ActionEntity {
    pub(crate) info: ActionInfo,
    pub(crate) entity: Entity,
    /// Where its value goes.
    pub(crate) input: CustomInput,
}

/// What actions say in this frame. From `Update` on it is complete.
#[derive(SystemParam)]
pub struct Controls<'w, 's> {
    entities: Res<'w, ActionEntities>,
    actions: Query<'w, 's, (&'static ActionValue, &'static ActionEvents, &'static TriggerState)>,
}

impl Controls<'_, '_> {
    /// Whether the action began in this frame.
    pub fn started<A: NamedAction>(&self) -> bool {
        self.get::<A>().is_some_and(|(_, events, _)| events.contains(ActionEvents::START))
    }

    /// Whether the action ended in this frame.
    pub fn ended<A: NamedAction>(&self) -> bool {
        self.get::<A>().is_some_and(|(_, events, _)| events.contains(ActionEvents::COMPLETE))
    }

    /// Whether it is being held.
    pub fn held<A: NamedAction>(&self) -> bool {
        self.get::<A>().is_some_and(|(_, _, state)| *state == TriggerState::Fired)
    }

    /// What was moved in this frame, in the action's unit.
    pub fn axis<A: NamedAction<Output = f32>>(&self) -> f32 {
        self.get::<A>().map_or(0.0, |(value, ..)| value.as_axis1d())
    }

    /// What was moved in this frame, to the right and up, in the action's unit.
    pub fn axis2<A: NamedAction<Output = Vec2>>(&self) -> Vec2 {
        self.get::<A>().map_or(Vec2::ZERO, |(value, ..)| value.as_axis2d())
    }

    fn get<A: NamedAction>(&self) -> Option<(&ActionValue, &ActionEvents, &TriggerState)> {
        let entity = self.entities.by_type.get(&TypeId::of::<A>())?;
        self.actions.get(*entity).ok()
    }
}

/// What any action says, by its name: for lists of all of them.
#[derive(SystemParam)]
pub struct ActionValues<'w, 's> {
    entities: Res<'w, ActionEntities>,
    actions: Query<'w, 's, (&'static ActionValue, &'static TriggerState)>,
}

/// What an action says in this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionSays {
    /// Which.
    pub info: ActionInfo,
    /// Whether it is used in this frame.
    pub held: bool,
    /// Its value in its unit; buttons are 1 or 0, and what has one number has it in `x`.
    pub value: Vec2,
}

impl ActionValues<'_, '_> {
    /// What an action says, if the app has it.
    pub fn get(&self, name: &str) -> Option<ActionSays> {
        self.iter().find(|says| says.info.name == name)
    }

    /// What all say, in the order in which they were added.
    pub fn iter(&self) -> impl Iterator<Item = ActionSays> {
        self.entities.all.iter().filter_map(|ActionEntity { info, entity, .. }| {
            let (value, state) = self.actions.get(*entity).ok()?;
            let held = *state == TriggerState::Fired;
            Some(ActionSays { info: *info, held, value: value.as_axis2d() })
        })
    }
}

/// Somebody pressed a button of an action: for notifications, sounds, statistics.
#[derive(Message, Clone, Copy, Debug, PartialEq)]
pub struct ActionPerformed {
    /// Which.
    pub action: ActionInfo,
}

/// Says which buttons began to be pressed.
pub(crate) fn announce(
    entities: Res<ActionEntities>,
    actions: Query<&ActionEvents, Changed<ActionEvents>>,
    mut performed: MessageWriter<ActionPerformed>,
) {
    for ActionEntity { info, entity, .. } in &entities.all {
        if info.kind == ActionKind::Button
            && actions.get(*entity).is_ok_and(|events| events.contains(ActionEvents::START))
        {
            performed.write(ActionPerformed { action: *info });
        }
    }
}
