//! What does what, for people.

use std::fmt::Write as _;

use crate::{ActionInfo, Binding, Bindings, Device, Source};

/// A line of help.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HelpLine {
    /// Under which heading it stands.
    pub group: &'static str,
    /// The action; of several that belong together, the first.
    pub action: &'static str,
    /// What it does.
    pub label: &'static str,
    /// How, in words: `right / left`.
    pub inputs: String,
}

/// Actions that share a line, and its label.
const TOGETHER: &[(&[&str], &str)] = &[
    (&["next_material", "previous_material"], "Next, previous material"),
    (&["next_model", "previous_model"], "Next, previous object"),
    (&["next_environment", "previous_environment"], "Next, previous environment"),
    (&["more_lights", "fewer_lights"], "More, fewer lights a frame"),
    (&["evaluation_1", "evaluation_2", "evaluation_3"], "Ways to evaluate materials"),
    (&["finer_picture", "coarser_picture"], "Finer, coarser picture"),
    (&["finer_material", "coarser_material"], "Finer, coarser material"),
    (&["brighter", "darker"], "Brighter, darker"),
    (&["turn_left", "turn_right"], "Turn yourself left, right"),
    (&["grab_left", "grab_right"], "Take hold"),
    (&["panel_next", "panel_previous"], "Next, previous control"),
    (&["panel_more", "panel_less"], "More, less"),
];

/// Headings, in order, and what stands under them; actions of a game stand under the last.
const GROUPS: &[(&str, &[&str])] = &[
    ("Menu", &["menu", "help", "quit"]),
    (
        "Move",
        &[
            "orbit",
            "pan",
            "zoom",
            "walk",
            "rise",
            "teleport",
            "turn_left",
            "turn_right",
            "recentre",
        ],
    ),
    (
        "Things",
        &[
            "rotate_object",
            "rotate_environment",
            "grab_left",
            "grab_right",
            "next_material",
            "previous_material",
            "next_model",
            "previous_model",
            "next_environment",
            "previous_environment",
            "next_lamps",
            "toggle_backdrop",
            "toggle_floor",
            "toggle_turning",
        ],
    ),
    (
        "Picture",
        &[
            "more_lights",
            "fewer_lights",
            "toggle_progressive",
            "toggle_image_based",
            "evaluation_1",
            "evaluation_2",
            "evaluation_3",
            "finer_picture",
            "coarser_picture",
            "finer_material",
            "coarser_material",
            "brighter",
            "darker",
            "screenshot",
            "xr_screenshot",
            "reset",
        ],
    ),
    (
        "In a panel",
        &[
            "panel_press",
            "panel_next",
            "panel_previous",
            "panel_more",
            "panel_less",
            "panel_scroll",
            "panel_back",
        ],
    ),
    ("Game", &[]),
];

/// What a device does under the bindings in force, in groups: a line for each action that has an
/// input, or for some that belong together. `added` are the game's own actions.
pub fn help(bindings: &Bindings, device: Device, added: &[ActionInfo]) -> Vec<HelpLine> {
    let mut lines = Vec::new();
    for (group, names) in GROUPS {
        for name in *names {
            let together = TOGETHER.iter().find(|(names, _)| names.contains(name));
            let first = together.is_none_or(|(names, _)| names[0] == *name);
            if let (true, Some(info)) = (first, crate::action(name)) {
                let all = together.map_or(std::slice::from_ref(name), |(names, _)| *names);
                lines.extend(line(bindings, device, group, info, all));
            }
        }
    }
    for info in added {
        lines.extend(line(bindings, device, "Game", info, &[info.name]));
    }
    lines
}

fn line(
    bindings: &Bindings,
    device: Device,
    group: &'static str,
    info: &ActionInfo,
    names: &[&str],
) -> Option<HelpLine> {
    let bound: Vec<_> = names.iter().map(|name| bindings.of(name, device)).collect();
    let most = bound.iter().map(Vec::len).max()?;
    let missing = bound.iter().filter(|list| list.is_empty()).count();
    let ways: Vec<_> = (0..most)
        .map(|at| row(&bound.iter().filter_map(|b| b.get(at)).collect::<Vec<_>>(), device))
        .collect();
    let label = TOGETHER.iter().find(|(together, _)| *together == names).map(|(_, label)| *label);
    let label = match label {
        Some(label) if missing == 0 => label,
        // Only one of them has an input: its own label says which.
        Some(_) if missing + 1 == names.len() => {
            let at = bound.iter().position(|list| !list.is_empty())?;
            crate::action(names[at])?.label
        }
        Some(label) => label,
        None => info.label,
    };
    (!ways.is_empty()).then(|| HelpLine {
        group,
        action: info.name,
        label,
        inputs: ways.join(", "),
    })
}

/// Bindings of actions that belong together: what they share with the first is said once.
fn row(bindings: &[&Binding], device: Device) -> String {
    let Some((first, rest)) = bindings.split_first() else { return String::new() };
    let stick = |binding: &Binding| match binding.source {
        Source::One(input) => input.stick(),
        _ => None,
    };
    let mut text = first.label_on(device);
    for binding in rest {
        let label = match (stick(first), stick(binding)) {
            _ if binding.held != first.held => binding.label_on(device),
            (Some((same, _)), Some((stick, way))) if stick == same => way.label().to_owned(),
            _ => binding.source.label_on(device),
        };
        let _ = write!(text, " / {label}");
    }
    text
}

/// [`help`] as a text, a paragraph for each group.
pub fn help_text(bindings: &Bindings, device: Device, added: &[ActionInfo]) -> String {
    let lines = help(bindings, device, added);
    let width = lines.iter().map(|line| line.label.chars().count()).max().unwrap_or(0);
    let mut text = format!("{device}. {}\n", first_hint(bindings, device));
    let mut group = "";
    for line in lines {
        if line.group != group {
            group = line.group;
            let _ = write!(text, "\n{group}\n");
        }
        let _ = writeln!(text, "  {:width$}  {}", line.label, line.inputs);
    }
    text
}

/// What the first screen says to somebody who has this device in hand: `M: menu, F1: help`. Empty if
/// neither has an input.
pub fn first_hint(bindings: &Bindings, device: Device) -> String {
    let says = |name: &str| {
        let bound = bindings.of(name, device);
        bound.first().map(|binding| format!("{}: {name}", binding.label_on(device)))
    };
    let hint = [says("menu"), says("help")].into_iter().flatten().collect::<Vec<_>>().join(", ");
    let mut letters = hint.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_action_has_one_group() {
        for info in crate::ACTIONS {
            let groups = GROUPS.iter().flat_map(|(_, names)| *names);
            assert_eq!(groups.filter(|name| **name == info.name).count(), 1, "{info}");
        }
        let named = GROUPS.iter().flat_map(|(_, names)| *names);
        let together = TOGETHER.iter().flat_map(|(names, _)| *names);
        for name in named.chain(together) {
            assert!(crate::action(name).is_some(), "{name}");
        }
    }
}
