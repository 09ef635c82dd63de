//! What is pressed on a headset's controllers becomes actions, in the same frame.

use bevy::{input::InputPlugin, prelude::*};
use farlight::{
    controls::{
        ActionPerformed, XrControllers,
        bindings::{
            ACTIONS, ActionInfo, ActionKind, Bindings, Context, Device, Hand, Input, Profile,
            Source, Xr,
        },
    },
    prelude::*,
    xr::XrPlugin,
};

fn app(profile: Profile) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        InputPlugin,
        TransformPlugin,
        ControlsPlugin::default(),
        XrPlugin::default(),
    ));
    app.finish();
    app.cleanup();
    for hand in &mut app.world_mut().resource_mut::<XrControllers>().hands {
        hand.profile = Some(profile);
    }
    (0..3).for_each(|_| app.update());
    app
}

/// Presses or lets go, and lets a frame pass. Gives the actions that began.
fn frame(app: &mut App, hand: Hand, input: Xr, down: bool) -> Vec<&'static str> {
    app.world_mut().resource_mut::<Messages<ActionPerformed>>().clear();
    let mut controllers = app.world_mut().resource_mut::<XrControllers>();
    let value = Vec2::new(f32::from(u8::from(down)), 0.0);
    controllers.hand_mut(hand).values.insert(input, value);
    app.update();
    let mut performed = app.world_mut().resource_mut::<Messages<ActionPerformed>>();
    performed.drain().map(|performed| performed.action.name).collect()
}

/// Buttons of the scene that one input presses.
fn buttons(profile: Profile) -> Vec<(&'static ActionInfo, Hand, Xr)> {
    let bindings = Bindings::default();
    let mut found = Vec::new();
    for info in ACTIONS {
        if info.kind != ActionKind::Button || info.context == Context::Panel {
            continue;
        }
        for binding in bindings.of(info.name, Device::Xr(profile)) {
            if let Source::One(Input::Xr(hand, input)) = binding.source
                && binding.held.is_empty()
            {
                found.push((info, hand, input));
            }
        }
    }
    found
}

#[test]
fn a_press_acts_within_its_frame_and_once() {
    for profile in [Profile::Index, Profile::Touch, Profile::Vive, Profile::Hands] {
        let mut app = app(profile);
        for (info, hand, input) in buttons(profile) {
            if info.name == "quit" {
                continue;
            }
            let what = format!("{profile:?}: {} by {hand:?}.{input:?}", info.name);
            let began = frame(&mut app, hand, input, true);
            assert!(began.contains(&info.name), "{what}: {began:?}");
            let again = frame(&mut app, hand, input, true);
            assert!(!again.contains(&info.name), "{what} is held, not pressed again");
            frame(&mut app, hand, input, false);
        }
    }
}
