//! Other inputs for actions, chosen by pressing them.

use bevy::prelude::*;
use farlight_bindings::{
    ActionInfo, ActionKind, Binding, Bindings, Device, Held, Input, Key, Shape, Source,
};

use crate::{
    ControlsInForce, ControlsStatus,
    layers::Layers,
    read::ActionEntities,
    sample::Sampling,
    slots::{SLOTS, Slot},
};

/// A drag, a wheel, or a hand that is swung counts as chosen after so many of its units.
const FAR: f32 = 24.0;
/// The same for what comes in lines and doublings.
const FAR_LINES: f32 = 0.9;
/// A stick is chosen when it is pushed this far.
const PUSHED: f32 = 0.7;
/// Most inputs to hold.
const MOST_HELD: usize = 3;

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

const PRESS: &str = "press something, or Esc to leave it as it is";

/// What to ask for first.
fn first(kind: ActionKind) -> &'static str {
    match kind {
        ActionKind::Button => PRESS,
        ActionKind::Axis => "turn a wheel or push a trigger, or press something for less",
        ActionKind::Axis2 => "drag, or push a stick, or press something for left",
    }
}

const PAIR: [&str; 2] = ["press something for less", "press something for more"];
const FOUR: [&str; 4] = [
    "press something for left",
    "press something for right",
    "press something for down",
    "press something for up",
];

/// Listens, and does what is wished.
pub(crate) fn rebind(
    mut rebinding: ResMut<Rebinding>,
    sampling: Res<Sampling>,
    entities: Res<ActionEntities>,
    status: Res<ControlsStatus>,
    mut in_force: ResMut<ControlsInForce>,
    mut layers: ResMut<Layers>,
) {
    if rebinding.wishes.is_empty() && !rebinding.is_waiting() {
        return;
    }
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

impl Rebinding {
    /// What has been chosen, once it has.
    fn listen(
        &mut self,
        sampling: &Sampling,
        target: &RebindTarget,
        info: ActionInfo,
    ) -> Option<Result<Binding, String>> {
        let inputs = &sampling.inputs;
        let mut let_go = None;
        for slot in 0..SLOTS.len() {
            let input = SLOTS.input(slot);
            if !input.is_of(target.device) {
                continue;
            }
            match input.shape() {
                // Two numbers want a stick as a whole, all else a direction of it.
                Shape::Stick => {
                    let pushed = inputs.values[slot].length() > PUSHED;
                    if pushed && info.kind == ActionKind::Axis2 && self.parts.is_empty() {
                        return Some(self.finish(Source::One(input), info));
                    }
                }
                Shape::Delta | Shape::Delta2 => {
                    self.moved[slot] += inputs.values[slot];
                    let lines = input.shape() == Shape::Delta
                        && !matches!(input, Input::Touch(farlight_bindings::Touch::Twist));
                    let far = self.moved[slot].length() > if lines { FAR_LINES } else { FAR };
                    let whole = input != Input::Mouse(farlight_bindings::Mouse::Move);
                    if far && whole && info.kind != ActionKind::Button && self.parts.is_empty() {
                        return Some(self.finish(Source::One(input), info));
                    }
                    if far && whole && self.pressed.is_empty() {
                        let moved = Binding::new(Source::One(input));
                        return moved.fits(info.kind).err().map(|error| Err(error.to_string()));
                    }
                }
                Shape::Button | Shape::Analog => {
                    let stick = input.stick().is_some() && info.kind == ActionKind::Axis2;
                    let slot16 = slot as Slot;
                    if inputs.began(slot) && !stick && !self.pressed.contains(&slot16) {
                        self.pressed.push(slot16);
                    }
                    // What lasts for a frame, such as a tap, is let go in the next.
                    if self.pressed.contains(&slot16) && !inputs.is_down_at_all(slot) {
                        let_go = Some(slot16);
                    }
                }
            }
        }
        let_go?;
        // The last that was pressed is meant, the others were held.
        let last = SLOTS.input(usize::from(self.pressed.pop()?));
        self.hold();
        self.pressed.clear();
        self.parts.push(last);
        let prompts = match info.kind {
            ActionKind::Button => &[PRESS][..],
            ActionKind::Axis if self.parts.len() == 1 && last.shape() == Shape::Analog => {
                // A trigger goes on its own, a direction of a stick wants the other one.
                if last.stick().is_some() { &PAIR[..] } else { &[PRESS][..] }
            }
            ActionKind::Axis => &PAIR[..],
            ActionKind::Axis2 => &FOUR[..],
        };
        if let Some(next) = prompts.get(self.parts.len()) {
            if let RebindState::Waiting { prompt, refused, .. } = &mut self.state {
                (*prompt, *refused) = (next, None);
            }
            return None;
        }
        let source = match self.parts[..] {
            [one] => Source::One(one),
            [less, more] => Source::Pair([less, more]),
            [left, right, down, up] => Source::Four([left, right, down, up]),
            _ => return Some(Err("that was one too many".into())),
        };
        self.parts.clear();
        Some(self.finish(source, info))
    }

    /// What is pressed is held for what comes.
    fn hold(&mut self) {
        for slot in std::mem::take(&mut self.pressed) {
            let held = match SLOTS.input(usize::from(slot)) {
                Input::Key(key) => match key.name() {
                    "ShiftLeft" | "ShiftRight" => Held::Shift,
                    "ControlLeft" | "ControlRight" => Held::Ctrl,
                    "AltLeft" | "AltRight" => Held::Alt,
                    _ => Held::Input(Input::Key(key)),
                },
                input => Held::Input(input),
            };
            if !self.held.contains(&held) {
                self.held.push(held);
            }
        }
    }

    fn finish(&mut self, source: Source, info: ActionInfo) -> Result<Binding, String> {
        self.hold();
        let mut held = std::mem::take(&mut self.held);
        // A drag holds its own button, a trackpad that is pushed its own click, maybe.
        let own = |held: &Held| match held {
            Held::Input(input) => source.inputs().iter().any(|part| part.overlaps(*input)),
            _ => false,
        };
        held.retain(|held| !own(held));
        if held.len() > MOST_HELD {
            return Err(format!("more than {MOST_HELD} inputs to hold"));
        }
        let binding = Binding { held, ..Binding::new(source) };
        binding.fits(info.kind).map_err(|error| error.to_string())?;
        Ok(binding)
    }
}

/// Whether what a binding says counts by the second.
fn is_rate(binding: &Binding) -> bool {
    let moves = |input: &Input| matches!(input.shape(), Shape::Delta | Shape::Delta2);
    !binding.source.inputs().iter().any(moves)
}

/// The new binding, as fast as the one that it replaces, or as another of the action is.
fn like(new: Binding, bindings: &Bindings, target: &RebindTarget, info: ActionInfo) -> Binding {
    if info.kind == ActionKind::Button {
        return new;
    }
    let here = bindings.of(&target.action, target.device);
    let replaced = here.get(target.slot).cloned();
    let elsewhere = Device::ALL.into_iter().flat_map(|device| bindings.of(&target.action, device));
    let mut models = replaced.into_iter().chain(here).chain(elsewhere);
    match models.find(|model| is_rate(model) == is_rate(&new)) {
        Some(model) => {
            let Binding { scale, invert_x, invert_y, .. } = model;
            Binding { scale, invert_x, invert_y, ..new }
        }
        None => new,
    }
}

/// Binds it, and takes what shares its inputs from the losers.
fn bind(bindings: &mut Bindings, target: &RebindTarget, binding: &Binding, losers: &[String]) {
    for loser in losers {
        let mut list = bindings.of(loser, target.device);
        list.retain(|other| !(binding.triggers(other) || other.triggers(binding)));
        bindings.set(loser, target.device, list);
    }
    let mut list = bindings.of(&target.action, target.device);
    match list.get_mut(target.slot) {
        Some(old) => *old = binding.clone(),
        None => list.push(binding.clone()),
    }
    let mut seen: Vec<Binding> = Vec::new();
    list.retain(|binding| {
        let new = seen.iter().all(|s| s.input_text() != binding.input_text());
        seen.push(binding.clone());
        new
    });
    bindings.set(&target.action, target.device, list);
}
