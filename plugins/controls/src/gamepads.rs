//! Gamepads, read in a thread of their own: whatever a device or a driver does, no frame waits for it.
//!
//! The controller of Schiller, *BTF Rendering in Virtual Reality*, 2022, section 7.9, took ten seconds to
//! start and held up every frame. Here the thread that opens devices is not the one that renders; what it
//! reads comes through a channel that holds [`CHANNEL`] events and becomes Bevy's own messages, so that
//! `Gamepad` entities, rumble requests and other crates work as with Bevy's own reader.

#[cfg(not(target_family = "wasm"))]
mod gilrs;
mod translate;

use std::{
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, Sender, SyncSender, TryRecvError, TrySendError, channel, sync_channel},
    },
    time::Duration,
};

use bevy::{
    input::{
        InputSystems,
        gamepad::{
            GamepadConnection, GamepadConnectionEvent, GamepadRumbleRequest,
            RawGamepadAxisChangedEvent, RawGamepadButtonChangedEvent, RawGamepadEvent,
        },
    },
    platform::collections::HashMap,
    prelude::*,
};

pub use translate::PadTable;

use crate::{ControlsStatus, ControlsSystems};

/// Events that the channel holds. When nobody takes them for so long, the thread waits; frames never do.
pub const CHANNEL: usize = 1024;
/// Events that a frame takes at most: a device that floods costs a bounded time.
pub const PER_FRAME: usize = 512;

/// What a source of gamepads says.
#[derive(Clone, Debug, PartialEq)]
pub enum PadEvent {
    /// A gamepad is there.
    Connected {
        /// Its number, unique among those that are there.
        pad: usize,
        /// Its name.
        name: String,
        /// USB's number of its maker.
        vendor: Option<u16>,
        /// The maker's number of it.
        product: Option<u16>,
    },
    /// It is gone.
    Disconnected {
        /// Its number.
        pad: usize,
    },
    /// A button, 0 to 1.
    Button {
        /// The number of the gamepad.
        pad: usize,
        /// Which.
        button: GamepadButton,
        /// 0 to 1.
        value: f32,
    },
    /// An axis, -1 to 1.
    Axis {
        /// The number of the gamepad.
        pad: usize,
        /// Which.
        axis: GamepadAxis,
        /// -1 to 1.
        value: f32,
    },
}

/// What an app asks of a gamepad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PadRequest {
    /// To shake.
    Rumble {
        /// The number of the gamepad.
        pad: usize,
        /// For how long.
        duration: Duration,
        /// How strongly the large motor turns, 0 to 1.
        strong: f32,
        /// How strongly the small motor turns, 0 to 1.
        weak: f32,
    },
    /// To be still.
    Stop {
        /// The number of the gamepad.
        pad: usize,
    },
}

/// Where events of gamepads come from: the machine, or a test. It lives in a thread of its own, is made
/// there, and may block.
pub trait PadSource {
    /// The next event, or `None` after a while (some tens of milliseconds) without one.
    fn next(&mut self) -> Option<PadEvent>;

    /// Something is asked of a gamepad.
    fn request(&mut self, request: PadRequest) {
        let _ = request;
    }
}

/// Makes a source, in the thread in which it will live.
pub type MakePadSource = Box<dyn FnOnce() -> Result<Box<dyn PadSource>, String> + Send + 'static>;

/// Reads gamepads in a thread of its own. [`ControlsPlugin`](crate::ControlsPlugin) adds it.
pub struct GamepadThreadPlugin {
    make: Mutex<Option<MakePadSource>>,
}

impl GamepadThreadPlugin {
    /// Reads from a source that this makes.
    pub fn new(make: impl FnOnce() -> Result<Box<dyn PadSource>, String> + Send + 'static) -> Self {
        Self { make: Mutex::new(Some(Box::new(make))) }
    }

    /// Reads the machine's gamepads, by gilrs. There is none on the web: Bevy's own reader (feature
    /// `bevy_gilrs`) is as good there, since browsers open devices themselves.
    #[cfg(not(target_family = "wasm"))]
    pub fn of_the_machine() -> Self {
        Self::new(gilrs::open)
    }
}

impl Plugin for GamepadThreadPlugin {
    fn build(&self, app: &mut App) {
        let make = self.make.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(make) = make else { return };
        app.init_resource::<ControlsStatus>();
        match PadThread::start(make) {
            Ok(thread) => {
                app.insert_resource(thread)
                    .add_message::<RawGamepadEvent>()
                    .add_message::<GamepadConnectionEvent>()
                    .add_message::<RawGamepadButtonChangedEvent>()
                    .add_message::<RawGamepadAxisChangedEvent>()
                    .add_message::<GamepadRumbleRequest>()
                    .add_systems(
                        PreUpdate,
                        receive.in_set(ControlsSystems::Gamepads).before(InputSystems),
                    )
                    .add_systems(PostUpdate, (rumble, stay_out.run_if(is_there_twice)));
            }
            Err(error) => {
                warn!("gamepads are not read: {error}");
                let mut status = app.world_mut().resource_mut::<ControlsStatus>();
                status.gamepads = GamepadReader::Failed(error);
            }
        }
    }
}

/// Where reading gamepads has got to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum GamepadReader {
    /// Nobody reads them here; Bevy's own reader may.
    #[default]
    Off,
    /// Devices are being opened; frames go on meanwhile.
    Starting,
    /// They are read.
    Running,
    /// They can't be; in words.
    Failed(String),
}

/// What the thread says.
enum Word {
    Ready,
    Failed(String),
    Event(PadEvent),
}

/// The thread, seen from the app.
#[derive(Resource)]
struct PadThread {
    words: Mutex<Receiver<Word>>,
    requests: Sender<PadRequest>,
    stop: Arc<AtomicBool>,
    pads: HashMap<usize, Entity>,
    /// What each calls itself.
    known: HashMap<Entity, GamepadConnection>,
}

impl PadThread {
    fn start(make: MakePadSource) -> Result<Self, String> {
        let (say, words) = sync_channel(CHANNEL);
        let (requests, asked) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        std::thread::Builder::new()
            .name("gamepads".into())
            .spawn(move || serve(make, &say, &asked, &stopped))
            .map_err(|error| error.to_string())?;
        Ok(Self {
            words: Mutex::new(words),
            requests,
            stop,
            pads: HashMap::default(),
            known: HashMap::default(),
        })
    }
}

impl Drop for PadThread {
    // Nobody waits for it: it may be stuck in a driver, and ends when it comes back.
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// The thread's own work.
fn serve(
    make: MakePadSource,
    say: &SyncSender<Word>,
    asked: &Receiver<PadRequest>,
    stop: &AtomicBool,
) {
    let mut source = match make() {
        Ok(source) => source,
        Err(error) => {
            let _ = say.send(Word::Failed(error));
            return;
        }
    };
    if say.send(Word::Ready).is_err() {
        return;
    }
    while !stop.load(Ordering::Relaxed) {
        for request in asked.try_iter() {
            source.request(request);
        }
        let Some(event) = source.next() else { continue };
        let mut word = Word::Event(event);
        // Waits while nobody takes events, but not for an app that is gone.
        loop {
            match say.try_send(word) {
                Ok(()) => break,
                Err(TrySendError::Disconnected(_)) => return,
                Err(TrySendError::Full(same)) => word = same,
            }
            if stop.load(Ordering::Relaxed) {
                return;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// Takes what has come, without waiting.
fn receive(
    mut thread: ResMut<PadThread>,
    mut status: ResMut<ControlsStatus>,
    mut commands: Commands,
    mut all: MessageWriter<RawGamepadEvent>,
    mut connections: MessageWriter<GamepadConnectionEvent>,
    mut buttons: MessageWriter<RawGamepadButtonChangedEvent>,
    mut axes: MessageWriter<RawGamepadAxisChangedEvent>,
) {
    if thread.stop.load(Ordering::Relaxed) {
        return;
    }
    let PadThread { words, pads, known, .. } = &mut *thread;
    let words = words.get_mut().unwrap_or_else(PoisonError::into_inner);
    if status.gamepads == GamepadReader::Off {
        status.gamepads = GamepadReader::Starting;
    }
    for _ in 0..PER_FRAME {
        let event = match words.try_recv() {
            Ok(Word::Ready) => {
                status.gamepads = GamepadReader::Running;
                continue;
            }
            Ok(Word::Failed(error)) => {
                warn!("gamepads are not read: {error}");
                status.gamepads = GamepadReader::Failed(error);
                continue;
            }
            Ok(Word::Event(event)) => event,
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => {
                if !matches!(status.gamepads, GamepadReader::Failed(_)) {
                    let gone = "its thread has ended".to_owned();
                    warn!("gamepads are not read: {gone}");
                    status.gamepads = GamepadReader::Failed(gone);
                }
                // Whatever was held is let go.
                for (_, gamepad) in pads.drain() {
                    let gone =
                        GamepadConnectionEvent::new(gamepad, GamepadConnection::Disconnected);
                    all.write(gone.clone().into());
                    connections.write(gone);
                }
                return;
            }
        };
        match event {
            PadEvent::Connected { pad, name, vendor, product } => {
                let gamepad = *pads.entry(pad).or_insert_with(|| commands.spawn_empty().id());
                let connection =
                    GamepadConnection::Connected { name, vendor_id: vendor, product_id: product };
                known.insert(gamepad, connection.clone());
                let event = GamepadConnectionEvent::new(gamepad, connection);
                all.write(event.clone().into());
                connections.write(event);
            }
            PadEvent::Disconnected { pad } => {
                // It keeps its entity: its settings stay, and it may come back.
                let Some(gamepad) = pads.get(&pad) else { continue };
                let event = GamepadConnectionEvent::new(*gamepad, GamepadConnection::Disconnected);
                all.write(event.clone().into());
                connections.write(event);
            }
            PadEvent::Button { pad, button, value } => {
                let Some(gamepad) = pads.get(&pad) else { continue };
                let event = RawGamepadButtonChangedEvent::new(*gamepad, button, value);
                all.write(event.into());
                buttons.write(event);
            }
            PadEvent::Axis { pad, axis, value } => {
                let Some(gamepad) = pads.get(&pad) else { continue };
                let event = RawGamepadAxisChangedEvent::new(*gamepad, axis, value);
                all.write(event.into());
                axes.write(event);
            }
        }
    }
}

/// Whether somebody else (Bevy's own reader) presents a gamepad that this one presents too.
fn is_there_twice(
    thread: Res<PadThread>,
    mut connections: MessageReader<GamepadConnectionEvent>,
    gamepads: Query<(Entity, &Gamepad, &Name)>,
) -> bool {
    if thread.stop.load(Ordering::Relaxed) || connections.read().count() == 0 {
        return false;
    }
    gamepads.iter().any(|(entity, gamepad, name)| {
        let connection = GamepadConnection::Connected {
            name: name.to_string(),
            vendor_id: gamepad.vendor_id(),
            product_id: gamepad.product_id(),
        };
        !thread.known.contains_key(&entity)
            && thread.known.iter().any(|(_, known)| *known == connection)
    })
}

/// Leaves gamepads to whoever reads them too.
fn stay_out(
    mut thread: ResMut<PadThread>,
    mut status: ResMut<ControlsStatus>,
    mut all: MessageWriter<RawGamepadEvent>,
    mut connections: MessageWriter<GamepadConnectionEvent>,
) {
    info!("gamepads are read by another plugin too: it goes on alone");
    thread.stop.store(true, Ordering::Relaxed);
    status.gamepads = GamepadReader::Off;
    for (_, gamepad) in thread.pads.drain() {
        let gone = GamepadConnectionEvent::new(gamepad, GamepadConnection::Disconnected);
        all.write(gone.clone().into());
        connections.write(gone);
    }
    thread.known.clear();
}

/// Passes requests on.
fn rumble(thread: Res<PadThread>, mut requests: MessageReader<GamepadRumbleRequest>) {
    for request in requests.read() {
        let number = |entity| thread.pads.iter().find(|(_, pad)| **pad == entity).map(|(n, _)| *n);
        let Some(pad) = number(request.gamepad()) else { continue };
        let _ = thread.requests.send(match request {
            GamepadRumbleRequest::Stop { .. } => PadRequest::Stop { pad },
            GamepadRumbleRequest::Add { duration, intensity, .. } => PadRequest::Rumble {
                pad,
                duration: *duration,
                strong: intensity.strong_motor,
                weak: intensity.weak_motor,
            },
        });
    }
}
