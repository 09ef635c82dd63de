//! The server's side of a session.

mod bases;
mod incoming;
mod outbox;
mod replica;
mod store;
mod tiles;
mod window;

use std::{collections::VecDeque, time::Duration};

use farlight_gi_solver::session::{LightingUpdate, SessionChange, SessionSettings, SnapshotId};

use crate::{
    Channel, Limits, ServerTimes, Token, Transmit, TransmitId, View, WireError,
    message::{ClientMessage, ServerMessage},
    ping::Pinger,
};
use outbox::Outbox;
use replica::Replica;

pub use store::BlobStore;

/// What a server session is made with.
#[derive(Clone, Debug, Default)]
pub struct ServerConfig {
    /// Bounds of what it takes.
    pub limits: Limits,
}

/// Names a session, so that a client that lost its connection finds it again. Secret, like a token.
pub type SessionKey = Token;

/// What a client says first.
#[derive(Clone, Debug, PartialEq)]
pub struct ClientHello {
    /// What it calls itself, for the log; at most 64 characters, none of them control characters.
    pub name: String,
    /// Must be the server's.
    pub token: Token,
    /// The session that it had before.
    pub resume: Option<SessionKey>,
    /// How lighting should be solved.
    pub settings: SessionSettings,
}

/// What the server answers to a greeting.
#[derive(Clone, Debug, PartialEq)]
pub struct Welcome {
    /// Names the session.
    pub key: SessionKey,
    /// Whether the server still has it.
    pub resumed: bool,
    /// The newest snapshot that it has of it.
    pub snapshot: SnapshotId,
    /// How lighting is solved: what was asked for, within the server's limits.
    pub settings: SessionSettings,
}

/// What a server session has to tell.
#[derive(Clone, Debug, PartialEq)]
pub enum ServerEvent {
    /// [`ServerSession::take_changes`] has something.
    Changed,
    /// Where the client looks from.
    View(View),
}

/// The size of a session's scene, for reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneSize {
    /// Meshes, textures, materials, instances, receivers, lights, the sky and grids.
    pub objects: usize,
    /// Triangles of all meshes.
    pub triangles: usize,
    /// Bytes of decoded meshes and images.
    pub blob_bytes: usize,
}

/// The server's side of a session. It outlives connections, so that a client can resume.
#[derive(Debug)]
pub struct ServerSession {
    key: SessionKey,
    settings: SessionSettings,
    config: ServerConfig,
    replica: Replica,
    outbox: Outbox,
    pinger: Pinger,
    attached: bool,
    /// The client has answered the welcome: it takes light.
    answered: bool,
    queue: VecDeque<Vec<u8>>,
    /// The newest snapshot is to be acknowledged.
    acknowledge: bool,
    events: VecDeque<ServerEvent>,
    /// Times since the last message.
    solve: Duration,
    encode: Duration,
    next_id: u64,
}

impl ServerSession {
    /// A session without a scene and without a connection.
    #[must_use]
    pub fn new(key: SessionKey, settings: SessionSettings, config: ServerConfig) -> Self {
        Self {
            key,
            settings,
            config,
            replica: Replica::default(),
            outbox: Outbox::default(),
            pinger: Pinger::default(),
            attached: false,
            answered: false,
            queue: VecDeque::new(),
            acknowledge: false,
            events: VecDeque::new(),
            solve: Duration::ZERO,
            encode: Duration::ZERO,
            next_id: 0,
        }
    }

    /// Its name.
    #[must_use]
    pub fn key(&self) -> SessionKey {
        self.key
    }

    /// How lighting is solved.
    #[must_use]
    pub fn settings(&self) -> &SessionSettings {
        &self.settings
    }

    /// A client whose greeting was accepted: welcomes it, and sends what it may not have. `resumed`:
    /// it had this session before.
    pub fn attach(&mut self, now: Duration, resumed: bool) {
        self.detach();
        self.attached = true;
        self.pinger.start(now);
        self.replica.reconnect();
        let welcome = Welcome {
            key: self.key,
            resumed,
            snapshot: self.replica.snapshot(),
            settings: self.settings.clone(),
        };
        self.queue.push_back(welcome.encode());
    }

    /// The link is gone; light goes on being collected.
    pub fn detach(&mut self) {
        self.attached = false;
        self.answered = false;
        self.queue.clear();
        self.acknowledge = false;
        self.outbox.detach();
        self.pinger = Pinger::default();
    }

    /// A message arrived (not the greeting).
    ///
    /// # Errors
    /// It doesn't fit; close the link with [`WireError::close_code`] and end the session.
    pub fn receive(
        &mut self,
        now: Duration,
        channel: Channel,
        message: &[u8],
        blobs: &BlobStore,
    ) -> Result<(), WireError> {
        let limits = self.config.limits;
        WireError::check("a message", message.len(), channel.limit(&limits))?;
        if !self.attached {
            return Err(WireError::Unexpected("a message without a connection".into()));
        }
        self.pinger.heard(now);
        let Some(message) = ClientMessage::decode(channel, message)? else { return Ok(()) };
        self.answered = true;
        match message {
            ClientMessage::Snapshot(part) => {
                if self.replica.receive(now, part, &limits, blobs)? {
                    self.acknowledge = true;
                }
            }
            ClientMessage::Chunk(chunk) => self.replica.chunk(chunk, &limits, blobs)?,
            ClientMessage::Gone(hash) => self.replica.gone(hash),
            ClientMessage::Acks(sequences) => {
                sequences.into_iter().for_each(|s| self.outbox.acknowledge(now, s));
            }
            ClientMessage::Resync => self.outbox.resync(),
            ClientMessage::View(view) => self.tell(ServerEvent::View(view)),
            ClientMessage::Ping(time) => self.pinger.asked(time),
            ClientMessage::Pong(time) => self.pinger.answered(now, time),
        }
        if self.replica.has_news() {
            self.tell(ServerEvent::Changed);
        }
        Ok(())
    }

    /// Queues an event; one of its kind is enough.
    fn tell(&mut self, event: ServerEvent) {
        self.events.retain(|e| std::mem::discriminant(e) != std::mem::discriminant(&event));
        self.events.push_back(event);
    }

    /// The next message to send; see [`ClientSession`](crate::ClientSession::poll_transmit). Encodes
    /// light, so measure it for [`note_encode`](Self::note_encode).
    pub fn poll_transmit(&mut self, now: Duration) -> Option<Transmit> {
        if !self.attached {
            return None;
        }
        if let Some(message) = self.next_control(now) {
            return Some(self.transmit(Channel::Control, message));
        }
        if !self.answered {
            return None;
        }
        let (solve, encode) = (self.solve, self.encode);
        let message = self.outbox.next(now, TransmitId(self.next_id + 1), |message| {
            if let Some(held) = self.replica.held(now, message.snapshot) {
                message.times = ServerTimes { held, solve, encode };
            }
        })?;
        self.solve = Duration::ZERO;
        self.encode = Duration::ZERO;
        Some(self.transmit(Channel::Latest, message))
    }

    fn next_control(&mut self, now: Duration) -> Option<Vec<u8>> {
        if let Some(message) = self.queue.pop_front() {
            return Some(message);
        }
        if std::mem::take(&mut self.acknowledge) {
            return Some(ServerMessage::Acknowledged(self.replica.snapshot()).encode());
        }
        if let Some(blobs) = self.replica.incoming.take_questions() {
            return Some(ServerMessage::Wanted(blobs).encode());
        }
        if let Some(time) = self.pinger.answer() {
            return Some(ServerMessage::Pong(time).encode());
        }
        // The client keeps a quiet connection alive.
        let busy = self.is_busy();
        let time = busy.then(|| self.pinger.due(now, true)).flatten()?;
        Some(ServerMessage::Ping(time).encode())
    }

    /// Whether something is expected from the client.
    fn is_busy(&self) -> bool {
        self.outbox.is_busy() || self.replica.waits_for_blobs()
    }

    fn transmit(&mut self, channel: Channel, message: Vec<u8>) -> Transmit {
        self.next_id += 1;
        Transmit { id: TransmitId(self.next_id), channel, message }
    }

    /// A message that need not arrive any more: newer light has replaced it.
    pub fn poll_cancel(&mut self) -> Option<TransmitId> {
        self.outbox.poll_cancel()
    }

    /// Tells the client something that people should know.
    pub fn notice(&mut self, text: &str) {
        if self.attached {
            self.queue.push_back(ServerMessage::Notice(text.to_owned()).encode());
        }
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<ServerEvent> {
        self.events.pop_front()
    }

    /// What the solver should apply next, if there is anything. Objects whose blobs are still on
    /// their way are left out until they are here.
    pub fn take_changes(&mut self) -> Option<(SnapshotId, Vec<SessionChange>)> {
        let (snapshot, changes) = self.replica.take_changes()?;
        for change in &changes {
            match change {
                SessionChange::RemoveReceiver(id) => self.outbox.remove_receiver(*id),
                SessionChange::RemoveGrid(id) => self.outbox.remove_grid(*id),
                _ => {}
            }
        }
        Some((snapshot, changes))
    }

    /// Takes light over to be sent; `solve` is the time that it took. What it replaces is dropped.
    pub fn publish(&mut self, _now: Duration, update: &LightingUpdate, solve: Duration) {
        self.solve += solve;
        // Light of a scene without what is still on its way is not the last word.
        let whole = !self.replica.waits_for_blobs() && !self.replica.has_news();
        let LightingUpdate { placements, refused, tiles, grids, .. } = update;
        let says_nothing =
            placements.is_empty() && refused.is_empty() && tiles.is_empty() && grids.is_empty();
        if whole || !says_nothing {
            self.outbox.publish(update, whole);
        }
    }

    /// The time that encoding took, for the next message.
    pub fn note_encode(&mut self, time: Duration) {
        self.encode += time;
    }

    /// When to call [`poll_transmit`](Self::poll_transmit) again although nothing happened.
    #[must_use]
    pub fn next_timeout(&self) -> Option<Duration> {
        (self.attached && self.is_busy()).then(|| self.pinger.next(true))
    }

    /// When the client was last heard of.
    #[must_use]
    pub fn last_heard(&self) -> Option<Duration> {
        self.pinger.last_heard()
    }

    /// The size of its scene.
    #[must_use]
    pub fn scene_size(&self) -> SceneSize {
        let (objects, triangles, blob_bytes) = self.replica.size();
        SceneSize { objects, triangles, blob_bytes }
    }
}
