//! From devices to values: what each action says in this frame.

use bevy::{prelude::*, time::Real};
use bevy_enhanced_input::{context::input_reader::custom::CustomInputs, prelude::*};
use farlight_bindings::{ActionInfo, ActionKind, Profile};

use crate::{
    InputCapture, PanelContext,
    compile::{compile, presses},
    evaluate::{Evaluator, Frame},
    gather::{Devices, Found},
    inputs::Inputs,
    plugin::ControlsInForce,
    read::ActionEntities,
    rebinding::Rebinding,
    slots::{Bases, Slot},
    spawn::ControlsRoot,
    touch::Fingers,
};

/// What is sampled.
#[derive(Resource)]
pub(crate) struct Sampling {
    bases: Bases,
    pub(crate) inputs: Inputs,
    pub(crate) evaluator: Evaluator,
    /// What each action says, in the order of [`ActionEntities`].
    said: Vec<Vec2>,
    presses: (Option<Profile>, Vec<Slot>),
    pub(crate) found: Found,
    fingers: Fingers,
    /// Bindings in force are not compiled yet.
    stale: bool,
}

impl Default for Sampling {
    fn default() -> Self {
        Self {
            bases: Bases::get(),
            inputs: Inputs::default(),
            evaluator: Evaluator::default(),
            said: Vec::new(),
            presses: (None, Vec::new()),
            found: Found::default(),
            fingers: Fingers::default(),
            stale: true,
        }
    }
}

/// Whether bindings or actions have changed since they were compiled.
pub(crate) fn is_stale(
    in_force: Res<ControlsInForce>,
    entities: Res<ActionEntities>,
    sampling: Res<Sampling>,
) -> bool {
    in_force.is_changed() || entities.is_changed() || sampling.stale
}

/// Compiles bindings.
pub(crate) fn rebind(
    in_force: Res<ControlsInForce>,
    entities: Res<ActionEntities>,
    mut sampling: ResMut<Sampling>,
) {
    let actions: Vec<ActionInfo> = entities.all.iter().map(|action| action.info).collect();
    sampling.evaluator.replace(compile(&in_force.bindings, &actions));
    sampling.said.resize(actions.len(), Vec2::ZERO);
    sampling.presses = (None, Vec::new());
    sampling.stale = false;
}

/// Gives every action its value.
pub(crate) fn sample(
    mut sampling: ResMut<Sampling>,
    mut devices: Devices,
    time: Res<Time<Real>>,
    capture: Res<InputCapture>,
    rebinding: Res<Rebinding>,
    entities: Res<ActionEntities>,
    mut custom: ResMut<CustomInputs>,
) {
    let Sampling { bases, inputs, evaluator, said, presses: pressing, found, fingers, .. } =
        &mut *sampling;
    let seconds = time.delta_secs();
    *found = devices.read(bases, inputs, fingers, seconds, capture.pointer);
    if pressing.0 != found.profile {
        *pressing = (found.profile, presses(evaluator.bindings(), found.profile));
    }
    inputs.settle(&capture, &pressing.1, found.lost);
    let frame = Frame {
        seconds,
        panel: capture.panel,
        mute: rebinding.is_waiting(),
        profile: found.profile,
    };
    evaluator.evaluate(inputs, frame, said);
    for (action, said) in entities.all.iter().zip(said.iter()) {
        custom.insert(action.input, value(action.info.kind, *said));
    }
}

/// A value as `bevy_enhanced_input` has it.
pub(crate) fn value(kind: ActionKind, value: Vec2) -> ActionValue {
    match kind {
        ActionKind::Button => (value.x > 0.0).into(),
        ActionKind::Axis => value.x.into(),
        ActionKind::Axis2 => value.into(),
    }
}

/// Actions of panels are heard while a panel wants it.
pub(crate) fn follow_panel(
    capture: Res<InputCapture>,
    roots: Query<(Entity, &ContextActivity<PanelContext>), With<ControlsRoot>>,
    mut commands: Commands,
) {
    for (root, active) in &roots {
        if **active != capture.panel {
            commands.entity(root).insert(ContextActivity::<PanelContext>::new(capture.panel));
        }
    }
}
