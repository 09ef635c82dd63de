//! Gamepads in a thread of their own: whatever it does, frames go on.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
    time::{Duration, Instant},
};

use bevy::{
    input::gamepad::{GamepadRumbleIntensity, GamepadRumbleRequest},
    prelude::*,
};
use farlight::controls::{
    ControlsPlugin, ControlsStatus, GamepadReader, GamepadThreadPlugin, UserFile,
    actions::*,
    gamepads::{PadEvent, PadRequest, PadSource},
};

use crate::player::Player;

/// Says what a test tells it to say.
struct Told {
    events: Receiver<PadEvent>,
    requests: Sender<PadRequest>,
}

impl PadSource for Told {
    fn next(&mut self) -> Option<PadEvent> {
        self.events.recv_timeout(Duration::from_millis(5)).ok()
    }

    fn request(&mut self, request: PadRequest) {
        let _ = self.requests.send(request);
    }
}

fn player(plugin: GamepadThreadPlugin) -> Player {
    let controls = ControlsPlugin { gamepads: false, user_file: UserFile::Nowhere, ..default() };
    Player::with_plugins(controls, Some(plugin))
}

fn state(player: &Player) -> GamepadReader {
    player.app.world().resource::<ControlsStatus>().gamepads.clone()
}

/// Runs frames until something is true; the thread decides when.
fn wait(player: &mut Player, until: impl Fn(&mut Player) -> bool) {
    let start = Instant::now();
    while !until(player) {
        assert!(start.elapsed() < Duration::from_secs(30), "it never happens");
        std::thread::sleep(Duration::from_millis(1));
        player.frame();
    }
}

fn connect(pad: usize) -> PadEvent {
    PadEvent::Connected { pad, name: format!("pad {pad}"), vendor: None, product: None }
}

fn pads(player: &mut Player) -> usize {
    player.app.world_mut().query::<&Gamepad>().iter(player.app.world()).count()
}

#[test]
fn frames_do_not_wait_for_a_device_that_takes_ten_seconds_to_start() {
    let started = Arc::new(AtomicBool::new(false));
    let starts = started.clone();
    let mut player = player(GamepadThreadPlugin::new(move || {
        std::thread::sleep(Duration::from_secs(10));
        starts.store(true, Ordering::SeqCst);
        Err("too late".into())
    }));
    // The keyboard works while it starts: a thousand frames of this app take far less than ten seconds,
    // and none of them would have come to an end if one had waited.
    for frame in 0..1000 {
        player.key(KeyCode::ArrowRight, frame % 2 == 0);
        player.frame();
        assert_eq!(player.held::<NextMaterial>(), frame % 2 == 0);
        if started.load(Ordering::SeqCst) {
            println!("SKIPPED: this machine needed ten seconds for {frame} frames");
            return;
        }
    }
    assert_eq!(state(&player), GamepadReader::Starting);
    // Nor does the end of the app wait for it.
    drop(player);
    assert!(!started.load(Ordering::SeqCst), "dropping the app waited for the device");
}

#[test]
fn what_a_source_says_acts_and_what_leaves_lets_go() {
    let (say, events) = channel();
    let (requests, asked) = channel();
    let mut player =
        player(GamepadThreadPlugin::new(move || Ok(Box::new(Told { events, requests }))));
    say.send(connect(7)).unwrap();
    wait(&mut player, |player| pads(player) == 1);
    assert_eq!(state(&player), GamepadReader::Running);
    say.send(PadEvent::Button { pad: 7, button: GamepadButton::East, value: 1.0 }).unwrap();
    wait(&mut player, |player| player.held::<NextMaterial>());
    let pad = player.app.world_mut().query_filtered::<Entity, With<Gamepad>>();
    let pad = { pad }.single(player.app.world()).unwrap();
    let (duration, intensity) = (Duration::from_millis(100), GamepadRumbleIntensity::MAX);
    player.send(GamepadRumbleRequest::Add { duration, intensity, gamepad: pad });
    player.frame();
    let asked = asked.recv_timeout(Duration::from_secs(30)).unwrap();
    assert_eq!(asked, PadRequest::Rumble { pad: 7, duration, strong: 1.0, weak: 1.0 });
    say.send(PadEvent::Disconnected { pad: 7 }).unwrap();
    wait(&mut player, |player| pads(player) == 0);
    assert!(!player.held::<NextMaterial>());
    // It comes back as the same entity; then its thread ends.
    say.send(connect(7)).unwrap();
    wait(&mut player, |player| pads(player) == 1);
    assert!(player.app.world().get::<Gamepad>(pad).is_some());
}

/// Never stops talking; panics if it is told to.
struct Flood(u64, u64);

impl PadSource for Flood {
    fn next(&mut self) -> Option<PadEvent> {
        self.0 += 1;
        assert!(self.0 < self.1, "the driver breaks");
        let pad = (self.0 % 8) as usize;
        Some(match self.0 % 16 {
            0..4 => connect(pad),
            4..8 => PadEvent::Disconnected { pad },
            _ => PadEvent::Axis { pad, axis: GamepadAxis::LeftStickX, value: f32::NAN },
        })
    }
}

#[test]
fn floods_and_breaks_are_borne() {
    let mut player = player(GamepadThreadPlugin::new(|| Ok(Box::new(Flood(0, 100_000)))));
    wait(&mut player, |player| matches!(state(player), GamepadReader::Failed(_)));
    player.frame();
    assert_eq!(pads(&mut player), 0, "what a broken thread held is let go");
    assert!(!player.held::<Orbit>());
    player.key(KeyCode::ArrowRight, true);
    player.frame();
    assert!(player.started::<NextMaterial>());
}

#[test]
fn a_wii_remote_is_no_gamepad() {
    let (say, events) = channel();
    let (requests, _) = channel();
    let mut player =
        player(GamepadThreadPlugin::new(move || Ok(Box::new(Told { events, requests }))));
    let name = "Nintendo Wii Remote".to_owned();
    say.send(PadEvent::Connected { pad: 0, name, vendor: Some(0x57e), product: Some(0x306) })
        .unwrap();
    let home = GamepadButton::Other(farlight_bindings::Wii::Home as u8);
    say.send(PadEvent::Button { pad: 0, button: home, value: 1.0 }).unwrap();
    wait(&mut player, |player| player.held::<Menu>());
    let active = player.app.world().resource::<farlight::controls::ActiveDevice>();
    assert_eq!(active.device, farlight_bindings::Device::WiiRemote);
    assert_eq!(active.name.as_deref(), Some("Nintendo Wii Remote"));
}

#[test]
fn a_gamepad_that_another_plugin_reads_too_is_left_to_it() {
    let (say, events) = channel();
    let (requests, _) = channel();
    let mut player =
        player(GamepadThreadPlugin::new(move || Ok(Box::new(Told { events, requests }))));
    say.send(connect(7)).unwrap();
    wait(&mut player, |player| pads(player) == 1);
    player.connect("somebody else's");
    player.frame();
    assert_eq!(pads(&mut player), 2);
    let theirs = player.connect("pad 7");
    player.frames(2);
    assert_eq!(pads(&mut player), 2, "that of the thread leaves");
    assert_eq!(state(&player), GamepadReader::Off);
    player.button(theirs, GamepadButton::East, 1.0);
    player.frame();
    assert!(player.started::<NextMaterial>());
}
