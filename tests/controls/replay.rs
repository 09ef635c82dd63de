//! Recordings: what actions said is said again, frame by frame.

use bevy::{
    input::{mouse::MouseScrollUnit, touch::TouchPhase},
    prelude::*,
};
use farlight::controls::{
    ActionPerformed, ActionRecorder, ActionReplay, ReplayPace, XrControllers, actions::*,
};
use farlight_bindings::{Hand, Profile, Recording, Xr};

use crate::player::Player;

/// What actions say in a frame.
type Frame = (Vec2, Vec2, f32, bool, bool, bool);

fn says(player: &mut Player) -> Frame {
    (
        player.axis2_of::<Orbit>(),
        player.axis2_of::<Walk>(),
        player.axis_of::<Zoom>(),
        player.started::<NextMaterial>(),
        player.held::<NextMaterial>(),
        player.ended::<NextMaterial>(),
    )
}

/// Uses every device, a frame of it.
fn play(player: &mut Player, frame: usize, pad: Entity) {
    match frame {
        1 => player.key(KeyCode::KeyW, true),
        3 => player.key(KeyCode::ArrowRight, true),
        5 => player.key(KeyCode::ArrowRight, false),
        8 => player.key(KeyCode::KeyW, false),
        10 => player.mouse(MouseButton::Left, true),
        11..15 => player.move_mouse(frame as f32, -3.5),
        15 => player.mouse(MouseButton::Left, false),
        16 => player.scroll(MouseScrollUnit::Line, -1.0),
        18 => player.axis(pad, GamepadAxis::LeftStickX, 0.7),
        20 => player.button(pad, GamepadButton::East, 1.0),
        22 => player.button(pad, GamepadButton::East, 0.0),
        24 => player.axis(pad, GamepadAxis::LeftStickX, 0.0),
        26 => player.finger(1, TouchPhase::Started, 50.0, 50.0),
        27..31 => player.finger(1, TouchPhase::Moved, 50.0 + 9.0 * (frame - 20) as f32, 61.0),
        31 => player.finger(1, TouchPhase::Ended, 150.0, 61.0),
        33 => {
            player.hold(Profile::Vive);
            player.hand(Hand::Left, Xr::TrackpadClick, 1.0, 0.0);
            player.hand(Hand::Left, Xr::Trackpad, -0.4, 0.9);
        }
        37 => *player.app.world_mut().resource_mut::<XrControllers>() = default(),
        _ => {}
    }
}

const FRAMES: usize = 42;

fn record() -> (Vec<Frame>, Recording) {
    let mut player = Player::new();
    let pad = player.connect("Test pad");
    player.app.world_mut().resource_mut::<ActionRecorder>().start();
    let frames = (0..FRAMES).map(|frame| {
        play(&mut player, frame, pad);
        player.frame();
        says(&mut player)
    });
    let frames = frames.collect();
    let recording = player.app.world_mut().resource_mut::<ActionRecorder>().stop().unwrap();
    (frames, recording)
}

#[test]
fn a_replay_says_the_same_in_every_frame() {
    let (recorded, recording) = record();
    assert!(recorded.iter().any(|frame| frame.0 != Vec2::ZERO) && recorded[3].3);
    // Through a file.
    let recording: Recording = recording.to_string().parse().unwrap();
    let mut player = Player::new();
    player.app.world_mut().resource_mut::<ActionReplay>().play(recording, ReplayPace::Frames);
    let mut performed = 0;
    for (at, frame) in recorded.iter().enumerate() {
        // Devices are not heard meanwhile.
        player.key(KeyCode::KeyD, true);
        player.frame();
        assert_eq!(says(&mut player), *frame, "frame {at}");
        let messages = player.app.world().resource::<Messages<ActionPerformed>>();
        let all = messages.iter_current_update_messages();
        performed += all.filter(|message| message.action.name == "next_material").count();
    }
    assert_eq!(performed, 2, "whoever reads actions notices nothing");
    player.frame();
    assert!(!player.app.world().resource::<ActionReplay>().is_playing());
    assert!(player.held::<Walk>(), "devices are heard again");
}

#[test]
fn a_replay_by_time_moves_as_far_whatever_frames_take() {
    let (recorded, recording) = record();
    let total = |frames: &[Frame]| frames.iter().map(|frame| frame.0 + frame.1).sum::<Vec2>();
    for seconds in [0.005, 0.05] {
        let mut player = Player::new();
        player.set_frame(seconds);
        let play = recording.clone();
        player.app.world_mut().resource_mut::<ActionReplay>().play(play, ReplayPace::Time);
        let mut frames = Vec::new();
        while player.app.world().resource::<ActionReplay>().is_playing() && frames.len() < 1000 {
            player.frame();
            frames.push(says(&mut player));
        }
        let (then, now) = (total(&recorded), total(&frames));
        assert!((then - now).length() < 1e-3 * then.length(), "{seconds} s: {then} and {now}");
        let pressed = frames.iter().filter(|frame| frame.3).count();
        assert_eq!(pressed, 2, "{seconds} s");
        assert!(recording.events().len() > 10);
    }
}
