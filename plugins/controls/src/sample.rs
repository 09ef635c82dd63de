//! From devices to values: what each binding says in this frame.

use bevy::{
    input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll},
    prelude::*,
};
use bevy_enhanced_input::{
    context::input_reader::custom::{CustomInput, CustomInputs},
    prelude::*,
};
use farlight_bindings::{ActionInfo, ActionKind, Device, Input, Key, Mouse, Source};

/// What is sampled.
#[derive(Resource, Default)]
pub(crate) struct Sampling {
    pub(crate) sampled: Vec<Sampled>,
}

/// A binding, and where its value goes.
pub(crate) struct Sampled {
    pub(crate) id: CustomInput,
    #[expect(dead_code, reason = "tells devices apart once there are several")]
    pub(crate) device: Device,
    pub(crate) info: ActionInfo,
    pub(crate) binding: farlight_bindings::Binding,
}

/// Gives every binding its value.
pub(crate) fn sample(
    sampling: Res<Sampling>,
    keys: Res<ButtonInput<KeyCode>>,
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    scroll: Res<AccumulatedMouseScroll>,
    mut custom: ResMut<CustomInputs>,
) {
    let value = |input: Input| -> Vec2 {
        let pressed = |down: bool| Vec2::new(f32::from(u8::from(down)), 0.0);
        let moved = motion.delta * Vec2::new(1.0, -1.0);
        match input {
            Input::Key(key) => pressed(key_code(key).is_some_and(|key| keys.pressed(key))),
            Input::Mouse(mouse) => match mouse {
                Mouse::Left => pressed(buttons.pressed(MouseButton::Left)),
                Mouse::Right => pressed(buttons.pressed(MouseButton::Right)),
                Mouse::Middle => pressed(buttons.pressed(MouseButton::Middle)),
                Mouse::Back => pressed(buttons.pressed(MouseButton::Back)),
                Mouse::Forward => pressed(buttons.pressed(MouseButton::Forward)),
                Mouse::Move => moved,
                Mouse::LeftDrag if buttons.pressed(MouseButton::Left) => moved,
                Mouse::RightDrag if buttons.pressed(MouseButton::Right) => moved,
                Mouse::MiddleDrag if buttons.pressed(MouseButton::Middle) => moved,
                Mouse::Wheel => Vec2::new(scroll.delta.y, 0.0),
                _ => Vec2::ZERO,
            },
            _ => Vec2::ZERO,
        }
    };
    for Sampled { id, info, binding, .. } in &sampling.sampled {
        let held = |held: &farlight_bindings::Held| held.inputs().iter().any(|&i| value(i).x > 0.5);
        let says = if binding.held.iter().all(held) {
            match binding.source {
                Source::One(input) => value(input),
                Source::Pair([less, more]) => value(more) - value(less),
                Source::Four([left, right, down, up]) => {
                    Vec2::new(value(right).x - value(left).x, value(up).x - value(down).x)
                }
            }
        } else {
            Vec2::ZERO
        };
        let says: ActionValue = match info.kind {
            ActionKind::Button => (says.x > 0.5).into(),
            ActionKind::Axis => says.x.into(),
            ActionKind::Axis2 => says.into(),
        };
        custom.insert(*id, says);
    }
}

/// Bevy's name of a key.
pub(crate) fn key_code(key: Key) -> Option<KeyCode> {
    use bevy::reflect::{
        PartialReflect as _,
        enums::{DynamicEnum, DynamicVariant},
    };
    let mut code = KeyCode::KeyA;
    code.try_apply(&DynamicEnum::new(key.name(), DynamicVariant::Unit)).ok()?;
    Some(code)
}
