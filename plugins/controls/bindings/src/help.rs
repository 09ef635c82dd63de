//! What does what, for people.

use crate::{ActionInfo, Bindings, Device};

/// A line of help.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HelpLine {
    /// The action.
    pub action: &'static str,
    /// What it does.
    pub label: &'static str,
    /// How, in words: `Shift + M, Page Up`.
    pub inputs: String,
}

/// What a device does under the bindings in force: a line an action that has an input, in order.
/// `added` are the game's own actions.
pub fn help(bindings: &Bindings, device: Device, added: &[ActionInfo]) -> Vec<HelpLine> {
    crate::ACTIONS
        .iter()
        .chain(added)
        .filter_map(|info| {
            let bound = bindings.of(info.name, device);
            let inputs: Vec<_> = bound.iter().map(|binding| binding.label()).collect();
            (!inputs.is_empty()).then(|| HelpLine {
                action: info.name,
                label: info.label,
                inputs: inputs.join(", "),
            })
        })
        .collect()
}
