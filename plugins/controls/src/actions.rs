//! The suite's actions as types of `bevy_enhanced_input`. Names, units and labels stand in
//! [`ACTIONS`](farlight_bindings::ACTIONS).

use bevy_enhanced_input::prelude::*;
use farlight_bindings::{ActionInfo, with_actions};

/// An action that bindings can name.
pub trait NamedAction: InputAction {
    /// Its name, label, kind, context and unit.
    fn info() -> ActionInfo;
}

macro_rules! output {
    (Button) => {
        bool
    };
    (Axis) => {
        f32
    };
    (Axis2) => {
        bevy::math::Vec2
    };
}

macro_rules! types {
    ($($type:ident, $name:literal, $kind:ident, $context:ident, $label:literal, $unit:literal;)*) => {
        $(
            #[doc = $label]
            #[derive(Clone, Copy, Debug)]
            pub struct $type;

            impl InputAction for $type {
                type Output = output!($kind);
            }

            impl NamedAction for $type {
                fn info() -> ActionInfo {
                    ActionInfo {
                        name: $name,
                        label: $label,
                        kind: farlight_bindings::ActionKind::$kind,
                        context: farlight_bindings::Context::$context,
                        unit: $unit,
                    }
                }
            }
        )*

        pub(crate) fn add_all(app: &mut bevy::app::App) {
            use crate::AddAction as _;
            $(app.add_action::<$type>();)*
        }
    };
}

with_actions!(types);
