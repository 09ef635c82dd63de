//! Other inputs for actions, chosen by pressing them.

mod bind;
mod listen;

use bevy::prelude::*;
use farlight_bindings::{Binding, Device, Held, Input, Key};

use self::{
    bind::{bind, like},
    listen::{PRESS, first},
};
use crate::{
    ControlsInForce, ControlsStatus,
    layers::Layers,
    read::ActionEntities,
    sample::Sampling,
    slots::{SLOTS, Slot},
};

/// Which binding is to be replaced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RebindTarget {
    /// The action's name.
    pub action: String,
    /// On this device; inputs of others are not listened to.
    pub device: Device,
    /// Its place in the list of the action's bindings; one past the end adds one.
    pub slot: usize,
}

/// How far rebinding has got.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RebindState {
    /// Nothing is being rebound.
    #[default]
    Idle,
    /// The next input is waited for; actions are not heard meanwhile. Esc cancels.
    Waiting {
        /// What for.
        target: RebindTarget,
        /// What to ask the player for: `press something`, `press something for left`.
        prompt: &'static str,
        /// Why the last input was refused.
        refused: Option<String>,
    },
    /// The input does something else too: [`Rebinding::resolve`] decides.
    Conflict {
        /// What for.
        target: RebindTarget,
        /// What was pressed.
        binding: Binding,
        /// The names of the actions that it would trigger too.
        with: Vec<String>,
    },
    /// It is bound. The next [`Rebinding::start`] forgets it.
    Done {
        /// What for.
        target: RebindTarget,
        /// What was pressed.
        binding: Binding,
    },
    /// It was cancelled.
    Cancelled,
}

/// What to do about a conflict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolve {
    /// The other actions lose the input.
    Replace,
    /// Both have it.
    KeepBoth,
    /// Everything stays as it was.
    Cancel,
}

/// What is asked of the systems.
#[derive(Clone, Debug, PartialEq)]
enum Wish {
    Resolve(Resolve),
    Reset(Option<(String, Device)>),
    Save,
}

/// Rebinds actions by listening to what is pressed:
///
/// ```
/// use bevy::prelude::*;
/// use farlight_controls::{RebindState, Rebinding, Resolve, bindings::Device};
///
/// fn button_pressed(mut rebinding: ResMut<Rebinding>) {
///     rebinding.start("menu", Device::KeyboardMouse, 0);
/// }
///
/// fn show(mut rebinding: ResMut<Rebinding>) {
///     match rebinding.state().clone() {
///         RebindState::Waiting { prompt, .. } => info!("{prompt}"),
///         RebindState::Conflict { .. } => rebinding.resolve(Resolve::Replace),
///         RebindState::Done { .. } => rebinding.save(),
///         _ => {}
///     }
/// }
/// # bevy::ecs::system::assert_is_system(button_pressed);
/// # bevy::ecs::system::assert_is_system(show);
/// ```
#[derive(Resource, Default)]
pub struct Rebinding {
    state: RebindState,
    wishes: Vec<Wish>,
    /// Inputs that went down since it began, in order.
    pressed: Vec<Slot>,
    /// Inputs of a pair or of four that have been chosen.
    parts: Vec<Input>,
    held: Vec<Held>,
    /// How far each input has moved.
    moved: Vec<Vec2>,
}

impl Rebinding {
    /// How far it has got.
    pub fn state(&self) -> &RebindState {
        &self.state
    }

    /// Whether the next input is listened to, and actions are not heard.
    pub fn is_waiting(&self) -> bool {
        matches!(self.state, RebindState::Waiting { .. })
    }

    /// Whether there is anything to do.
    pub(crate) fn is_busy(&self) -> bool {
        self.is_waiting() || !self.wishes.is_empty()
    }

    /// Listens for an input of `device` for an action. `slot` is the place in the list of its bindings.
    pub fn start(&mut self, action: &str, device: Device, slot: usize) {
        let target = RebindTarget { action: action.to_owned(), device, slot };
        self.begin_again();
        self.parts.clear();
        self.held.clear();
        self.state = RebindState::Waiting { target, prompt: PRESS, refused: None };
    }

    /// Everything stays as it was.
    pub fn cancel(&mut self) {
        self.state = RebindState::Cancelled;
    }

    /// Decides about a conflict.
    pub fn resolve(&mut self, resolve: Resolve) {
        self.wishes.push(Wish::Resolve(resolve));
    }

    /// Binds to an action on a device what the game binds.
    pub fn reset(&mut self, action: &str, device: Device) {
        self.wishes.push(Wish::Reset(Some((action.to_owned(), device))));
    }

    /// Has everything as the game has it.
    pub fn reset_all(&mut self) {
        self.wishes.push(Wish::Reset(None));
    }

    /// Writes the user's own changes to [`ControlsPlugin::user_file`](crate::ControlsPlugin::user_file).
    /// What is wrong with that stands in [`ControlsStatus::problems`](crate::ControlsStatus::problems).
    pub fn save(&mut self) {
        self.wishes.push(Wish::Save);
    }

    fn begin_again(&mut self) {
        self.pressed.clear();
        self.moved.clear();
        self.moved.resize(SLOTS.len(), Vec2::ZERO);
    }

    fn refuse(&mut self, reason: String) {
        self.begin_again();
        self.parts.clear();
        self.held.clear();
        if let RebindState::Waiting { refused, .. } = &mut self.state {
            *refused = Some(reason);
        }
    }
}

/// Listens, and does what is wished.
pub(crate) fn rebind(
    mut rebinding: ResMut<Rebinding>,
    sampling: Res<Sampling>,
    entities: Res<ActionEntities>,
    status: Res<ControlsStatus>,
    mut in_force: ResMut<ControlsInForce>,
    mut layers: ResMut<Layers>,
) {
    let rebinding = &mut *rebinding;
    for wish in std::mem::take(&mut rebinding.wishes) {
        match wish {
            Wish::Save => layers.save(),
            Wish::Reset(Some((action, device))) => {
                let list = layers.base().of(&action, device);
                in_force.bindings.set(&action, device, list);
            }
            Wish::Reset(None) => in_force.bindings = layers.base().clone(),
            Wish::Resolve(resolve) => {
                let RebindState::Conflict { target, binding, with } = &rebinding.state else {
                    continue;
                };
                let (target, binding, with) = (target.clone(), binding.clone(), with.clone());
                rebinding.state = match resolve {
                    Resolve::Cancel => RebindState::Cancelled,
                    _ => {
                        let losers = if resolve == Resolve::Replace { &with[..] } else { &[] };
                        bind(&mut in_force.bindings, &target, &binding, losers);
                        RebindState::Done { target, binding }
                    }
                };
            }
        }
    }
    let RebindState::Waiting { target, .. } = &rebinding.state else { return };
    let target = target.clone();
    let mut infos = entities.all.iter().map(|action| action.info);
    let Some(info) = infos.find(|info| info.name == target.action) else {
        return rebinding.refuse(format!("there is no action {:?}", target.action));
    };
    if rebinding.parts.is_empty()
        && let RebindState::Waiting { prompt, .. } = &mut rebinding.state
    {
        *prompt = first(info.kind);
    }
    let escape = Key::named("Escape").map(|key| usize::from(SLOTS.of(Input::Key(key))));
    if escape.is_some_and(|slot| sampling.inputs.began(slot)) {
        return rebinding.cancel();
    }
    let Some(chosen) = rebinding.listen(&sampling, &target, info) else { return };
    let binding = match chosen {
        Ok(binding) => like(binding, &in_force.bindings, &target, info),
        Err(reason) => return rebinding.refuse(reason),
    };
    let rivals = in_force.bindings.rivals(&target.action, target.device, &binding, &status.added);
    rebinding.state = if rivals.is_empty() {
        bind(&mut in_force.bindings, &target, &binding, &[]);
        RebindState::Done { target, binding }
    } else {
        let with = rivals.into_iter().map(str::to_owned).collect();
        RebindState::Conflict { target, binding, with }
    };
}
