//! An app without a window, and somebody who uses its devices through Bevy's own messages.

use std::{path::Path, time::Duration};

use bevy::{
    ecs::system::RunSystemOnce,
    input::{
        ButtonState, InputPlugin,
        gamepad::{
            GamepadConnection, GamepadConnectionEvent, RawGamepadAxisChangedEvent,
            RawGamepadButtonChangedEvent, RawGamepadEvent,
        },
        keyboard::{Key, KeyboardFocusLost, KeyboardInput},
        mouse::{MouseButtonInput, MouseMotion, MouseScrollUnit, MouseWheel},
        touch::{TouchInput, TouchPhase},
    },
    prelude::*,
    time::TimeUpdateStrategy,
};
use farlight::controls::{
    Controls, ControlsPlugin, GamepadThreadPlugin, UserFile, XrControllers, actions::NamedAction,
};
use farlight_bindings::{Hand, Profile, Xr};

/// Length of a frame in seconds.
pub(crate) const FRAME: f32 = 1.0 / 64.0;

pub(crate) struct Player {
    pub(crate) app: App,
    window: Entity,
}

impl Player {
    /// An app with the default bindings; no gamepads of the machine, nothing that is saved.
    pub(crate) fn new() -> Self {
        Self::with(ControlsPlugin { gamepads: false, user_file: UserFile::Nowhere, ..default() })
    }

    pub(crate) fn with(plugin: ControlsPlugin) -> Self {
        Self::with_plugins(plugin, None)
    }

    pub(crate) fn with_assets(plugin: ControlsPlugin, folder: &Path) -> Self {
        let file_path = folder.display().to_string();
        Self::build(plugin, None, AssetPlugin { file_path, ..default() })
    }

    pub(crate) fn with_plugins(
        plugin: ControlsPlugin,
        gamepads: Option<GamepadThreadPlugin>,
    ) -> Self {
        Self::build(plugin, gamepads, AssetPlugin::default())
    }

    fn build(
        plugin: ControlsPlugin,
        gamepads: Option<GamepadThreadPlugin>,
        assets: AssetPlugin,
    ) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, assets, InputPlugin, plugin));
        if let Some(gamepads) = gamepads {
            app.add_plugins(gamepads);
        }
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(FRAME)));
        app.finish();
        app.cleanup();
        let window = app.world_mut().spawn_empty().id();
        let mut player = Self { app, window };
        player.frame();
        player
    }

    /// How long frames are from now on, in seconds.
    pub(crate) fn set_frame(&mut self, seconds: f32) {
        let length = Duration::from_secs_f32(seconds);
        self.app.insert_resource(TimeUpdateStrategy::ManualDuration(length));
    }

    pub(crate) fn frame(&mut self) {
        self.app.update();
    }

    pub(crate) fn frames(&mut self, frames: usize) {
        for _ in 0..frames {
            self.frame();
        }
    }

    pub(crate) fn send<M: Message>(&mut self, message: M) {
        self.app.world_mut().write_message(message);
    }

    pub(crate) fn key(&mut self, key_code: KeyCode, down: bool) {
        let state = if down { ButtonState::Pressed } else { ButtonState::Released };
        let window = self.window;
        self.send(KeyboardInput {
            key_code,
            logical_key: Key::Dead(None),
            state,
            text: None,
            repeat: false,
            window,
        });
    }

    pub(crate) fn mouse(&mut self, button: MouseButton, down: bool) {
        let state = if down { ButtonState::Pressed } else { ButtonState::Released };
        let window = self.window;
        self.send(MouseButtonInput { button, state, window });
    }

    /// To the right and down, as mice count.
    pub(crate) fn move_mouse(&mut self, x: f32, y: f32) {
        self.send(MouseMotion { delta: Vec2::new(x, y) });
    }

    pub(crate) fn scroll(&mut self, unit: MouseScrollUnit, y: f32) {
        let window = self.window;
        self.send(MouseWheel { unit, x: 0.0, y, window, phase: TouchPhase::Moved });
    }

    pub(crate) fn lose_focus(&mut self) {
        self.send(KeyboardFocusLost);
    }

    pub(crate) fn finger(&mut self, id: u64, phase: TouchPhase, x: f32, y: f32) {
        let (window, position) = (self.window, Vec2::new(x, y));
        self.send(TouchInput { phase, position, window, force: None, id });
    }

    pub(crate) fn connect(&mut self, name: &str) -> Entity {
        let pad = self.app.world_mut().spawn_empty().id();
        let connection =
            GamepadConnection::Connected { name: name.into(), vendor_id: None, product_id: None };
        self.raw(RawGamepadEvent::Connection(GamepadConnectionEvent::new(pad, connection)));
        self.frame();
        pad
    }

    pub(crate) fn disconnect(&mut self, pad: Entity) {
        let gone = GamepadConnection::Disconnected;
        self.raw(RawGamepadEvent::Connection(GamepadConnectionEvent::new(pad, gone)));
    }

    pub(crate) fn button(&mut self, pad: Entity, button: GamepadButton, value: f32) {
        self.raw(RawGamepadEvent::Button(RawGamepadButtonChangedEvent::new(pad, button, value)));
    }

    pub(crate) fn axis(&mut self, pad: Entity, axis: GamepadAxis, value: f32) {
        self.raw(RawGamepadEvent::Axis(RawGamepadAxisChangedEvent::new(pad, axis, value)));
    }

    fn raw(&mut self, event: RawGamepadEvent) {
        match event.clone() {
            RawGamepadEvent::Connection(event) => self.send(event),
            RawGamepadEvent::Button(event) => self.send(event),
            RawGamepadEvent::Axis(event) => self.send(event),
        }
        self.send(event);
    }

    pub(crate) fn hold(&mut self, profile: Profile) {
        let mut hands = self.app.world_mut().resource_mut::<XrControllers>();
        for hand in Hand::ALL {
            hands.hand_mut(hand).profile = Some(profile);
        }
    }

    pub(crate) fn hand(&mut self, hand: Hand, input: Xr, x: f32, y: f32) {
        let mut hands = self.app.world_mut().resource_mut::<XrControllers>();
        hands.hand_mut(hand).values.insert(input, Vec2::new(x, y));
    }

    fn read<T: 'static>(&mut self, read: fn(&Controls) -> T) -> T {
        let system = move |controls: Controls| read(&controls);
        self.app.world_mut().run_system_once(system).unwrap()
    }

    pub(crate) fn started<A: NamedAction>(&mut self) -> bool {
        self.read(|controls| controls.started::<A>())
    }

    pub(crate) fn held<A: NamedAction>(&mut self) -> bool {
        self.read(|controls| controls.held::<A>())
    }

    pub(crate) fn ended<A: NamedAction>(&mut self) -> bool {
        self.read(|controls| controls.ended::<A>())
    }

    pub(crate) fn axis_of<A: NamedAction<Output = f32>>(&mut self) -> f32 {
        self.read(|controls| controls.axis::<A>())
    }

    pub(crate) fn axis2_of<A: NamedAction<Output = Vec2>>(&mut self) -> Vec2 {
        self.read(|controls| controls.axis2::<A>())
    }
}
