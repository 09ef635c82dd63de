//! Inputs that do more than one thing at once.

use std::{collections::BTreeMap, fmt};

use farlight_ron::place_of;

use crate::{ActionInfo, Binding, Bindings, Context, Device};

/// An input that does more than one thing at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conflict {
    /// On this device.
    pub device: Device,
    /// The input, as files write it: `Shift+KeyM`.
    pub input: String,
    /// What it does: names of actions, the first of them by the input as it stands above, the others
    /// by it or by a part of it.
    pub actions: Vec<String>,
}

impl fmt::Display for Conflict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { device, input, actions } = self;
        let (last, others) = actions.split_last().map_or(("", &[][..]), |(l, o)| (l, o));
        write!(f, "{device}: {input} does {} and {last} at once", others.join(", "))
    }
}

impl Conflict {
    /// Line and column, in the text of the file that made `bindings`, of the list that binds the input
    /// to one of its actions.
    pub fn place(&self, bindings: &Bindings, text: &str) -> Option<(usize, usize)> {
        let own = self.actions.iter().find_map(|name| Some((name, bindings.bindings.get(name)?)));
        let (name, own) = own?;
        let list = match self.device {
            Device::Xr(_) if own.own(self.device).is_none() => "xr",
            device => device.name(),
        };
        place_of(text, &format!("bindings.{name}.{list}"))
    }
}

impl Binding {
    /// Whether using this one also uses `other`, a binding of another action of the same device that
    /// is heard at the same time: the same input with the same things held; or `other` is what has to
    /// be held for this one, so that it has acted before this one can. What is masked
    /// ([`is_masked_by`](Self::is_masked_by)) doesn't act; and two that want different things held act
    /// together only for somebody who holds both.
    pub fn triggers(&self, other: &Self) -> bool {
        if !self.wants_all_of(other) {
            return false;
        }
        let same = other.wants_all_of(self) && self.shares_source(other);
        same || self
            .held
            .iter()
            .flat_map(|held| held.inputs())
            .any(|held| other.source.inputs().iter().any(|input| input.overlaps(held)))
    }

    /// Whether this binding of an open panel takes inputs away from `other`, one of the scene or of
    /// what is always heard: they have any in common, those to hold as well. The panel that goes to
    /// the control before by `Shift+Tab` sinks nobody who uses it.
    pub fn takes_from(&self, other: &Self) -> bool {
        let others = other.inputs();
        self.inputs().iter().any(|input| others.iter().any(|other| other.overlaps(*input)))
    }
}

/// An open panel takes its inputs away from everything else.
fn together(a: Context, b: Context) -> bool {
    (a == Context::Panel) == (b == Context::Panel)
}

impl Bindings {
    /// Inputs of a device that do more than one thing at once. `added` are the game's own actions.
    pub fn conflicts(&self, device: Device, added: &[ActionInfo]) -> Vec<Conflict> {
        let mut found = BTreeMap::<(usize, String), Vec<String>>::new();
        let all = self.all(device, added);
        for (at, (info, binding)) in all.iter().enumerate() {
            let rivals = all.iter().enumerate().filter(|(other_at, (other, rival))| {
                let both = binding.triggers(rival) && rival.triggers(binding);
                other.name != info.name
                    && together(info.context, other.context)
                    && binding.triggers(rival)
                    // Those that trigger each other are one conflict.
                    && !(both && *other_at < at)
            });
            let mut names: Vec<String> = rivals.map(|(_, (other, _))| other.name.into()).collect();
            names.dedup();
            // A third one that is in conflict with the first is in it already.
            let known = |(_, input): &(usize, String), actions: &Vec<String>| {
                *input == binding.input_text() && names.iter().all(|name| actions.contains(name))
            };
            if !names.is_empty() && !found.iter().any(|(key, actions)| known(key, actions)) {
                names.insert(0, info.name.into());
                found.insert((at, binding.input_text()), names);
            }
        }
        found.into_iter().map(|((_, input), actions)| Conflict { device, input, actions }).collect()
    }

    /// The actions that `binding` would be in conflict with if it were bound to `action` on a device:
    /// what somebody wants to know who is about to bind it.
    pub fn rivals(
        &self,
        action: &str,
        device: Device,
        binding: &Binding,
        added: &[ActionInfo],
    ) -> Vec<&'static str> {
        let mut actions = crate::ACTIONS.iter().chain(added);
        let Some(info) = actions.find(|info| info.name == action) else { return Vec::new() };
        let all = self.all(device, added);
        let rivals = all.iter().filter(|(other, rival)| {
            other.name != action
                && together(info.context, other.context)
                && (binding.triggers(rival) || rival.triggers(binding))
        });
        let mut names: Vec<_> = rivals.map(|(other, _)| other.name).collect();
        names.dedup();
        names
    }

    /// Every binding of a device.
    fn all<'a>(&self, device: Device, added: &'a [ActionInfo]) -> Vec<(&'a ActionInfo, Binding)> {
        let actions = crate::ACTIONS.iter().chain(added);
        actions
            .flat_map(|info| {
                let bound = self.of(info.name, device).into_iter();
                // What doesn't fit does nothing.
                bound.filter(|b| b.fits(info.kind).is_ok()).map(move |binding| (info, binding))
            })
            .collect()
    }
}
