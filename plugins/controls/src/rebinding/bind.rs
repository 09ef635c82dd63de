//! Puts what was chosen among the bindings in force.

use farlight_bindings::{ActionInfo, ActionKind, Binding, Bindings, Device, Input, Shape};

use super::RebindTarget;

/// Whether what a binding says counts by the second.
fn is_rate(binding: &Binding) -> bool {
    let moves = |input: &Input| matches!(input.shape(), Shape::Delta | Shape::Delta2);
    !binding.source.inputs().iter().any(moves)
}

/// The new binding, as fast as the one that it replaces, or as another of the action is.
pub(super) fn like(
    new: Binding,
    bindings: &Bindings,
    target: &RebindTarget,
    info: ActionInfo,
) -> Binding {
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
pub(super) fn bind(
    bindings: &mut Bindings,
    target: &RebindTarget,
    binding: &Binding,
    losers: &[String],
) {
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
