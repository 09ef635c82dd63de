//! The suite's actions as types of `bevy_enhanced_input`. Names, units and labels stand in
//! [`ACTIONS`](farlight_bindings::ACTIONS).

use bevy_enhanced_input::prelude::*;
use farlight_bindings::{ActionInfo, with_actions};

/// An action that bindings can name.
pub trait NamedAction: InputAction {
    /// Its name, label, kind, context and unit.
    fn info() -> ActionInfo;
}

/// Declares actions of a game: type, kind (`Button`, `Axis`, `Axis2`), name in files, words for people,
/// context (`Scene`, `Global`, `Panel`) and, of axes, what a value of 1 is.
///
/// ```
/// use bevy::prelude::*;
/// use farlight_controls::{AddAction, Controls, named_action};
///
/// named_action! {
///     /// Rings the bell.
///     pub struct RingBell: Button, "ring_bell", "Ring the bell", Scene;
///     /// Raises and lowers the bridge.
///     pub struct Bridge: Axis, "bridge", "Raise, lower the bridge", Scene, "metres";
/// }
///
/// fn play(controls: Controls) {
///     if controls.started::<RingBell>() {
///         info!("ding");
///     }
///     let raised = controls.axis::<Bridge>();
/// #   let _ = raised;
/// }
///
/// # let mut app = App::new();
/// app.add_action::<RingBell>().add_action::<Bridge>().add_systems(Update, play);
/// ```
///
/// Bindings come from a file, by name: `"ring_bell": (keyboard_mouse: ["KeyJ"], gamepad: ["Mode"])`.
#[macro_export]
macro_rules! named_action {
    ($($(#[$meta:meta])* $vis:vis struct $type:ident: $kind:ident, $name:literal, $label:literal,
        $context:ident $(, $unit:literal)?;)*) => {
        $(
            $(#[$meta])*
            #[derive(Clone, Copy, Debug)]
            $vis struct $type;

            impl $crate::bevy_enhanced_input::prelude::InputAction for $type {
                type Output = $crate::action_output!($kind);
            }

            impl $crate::actions::NamedAction for $type {
                fn info() -> $crate::bindings::ActionInfo {
                    $crate::bindings::ActionInfo {
                        name: $name,
                        label: $label,
                        kind: $crate::bindings::ActionKind::$kind,
                        context: $crate::bindings::Context::$context,
                        unit: concat!($($unit)?),
                    }
                }
            }
        )*
    };
}

/// What an action of a kind gives.
#[doc(hidden)]
#[macro_export]
macro_rules! action_output {
    (Button) => {
        bool
    };
    (Axis) => {
        f32
    };
    (Axis2) => {
        $crate::Vec2
    };
}

macro_rules! types {
    ($($type:ident, $name:literal, $kind:ident, $context:ident, $label:literal, $unit:literal;)*) => {
        $crate::named_action! {
            $(
                #[doc = $label]
                pub struct $type: $kind, $name, $label, $context, $unit;
            )*
        }

        pub(crate) fn add_all(app: &mut bevy::app::App) {
            use crate::AddAction as _;
            $(app.add_action::<$type>();)*
        }
    };
}

with_actions!(types);
