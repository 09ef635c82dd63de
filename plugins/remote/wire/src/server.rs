//! The server's side of a session.

use std::time::Duration;

use farlight_gi_solver::session::{LightingUpdate, SessionChange, SessionSettings, SnapshotId};

use crate::{Channel, Limits, Token, Transmit, TransmitId, View, WireError};

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

impl ClientHello {
    /// Reads the first message of a connection.
    ///
    /// # Errors
    /// It is not a greeting, or of a version that can't be understood.
    pub fn read(_channel: Channel, _message: &[u8], _limits: &Limits) -> Result<Self, WireError> {
        todo!()
    }
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

/// Decoded meshes and images by content, shared by the sessions of a server, with a bound. What no
/// session uses goes first, oldest first.
#[derive(Debug, Default)]
pub struct BlobStore {}

impl BlobStore {
    /// A store that keeps at most so many bytes beyond what sessions use.
    #[must_use]
    pub fn new(_unused_bytes: usize) -> Self {
        todo!()
    }

    /// Bytes of all that it holds.
    #[must_use]
    pub fn bytes(&self) -> usize {
        todo!()
    }
}

/// The server's side of a session. It outlives connections, so that a client can resume.
#[derive(Debug)]
pub struct ServerSession {
    config: ServerConfig,
}

impl ServerSession {
    /// A session without a scene and without a connection.
    #[must_use]
    pub fn new(_key: SessionKey, _settings: SessionSettings, config: ServerConfig) -> Self {
        Self { config }
    }

    /// A client whose greeting was accepted: welcomes it, and sends what it may not have.
    pub fn attach(&mut self, _now: Duration, _resumed: bool) {
        todo!()
    }

    /// The link is gone; light goes on being collected.
    pub fn detach(&mut self) {
        todo!()
    }

    /// A message arrived (not the greeting).
    ///
    /// # Errors
    /// It doesn't fit; close the link with the code that [`WireError::close_code`] names.
    pub fn receive(
        &mut self,
        _now: Duration,
        _channel: Channel,
        _message: &[u8],
        _blobs: &mut BlobStore,
    ) -> Result<(), WireError> {
        todo!()
    }

    /// The network has taken a message over.
    pub fn sent(&mut self, _now: Duration, _id: TransmitId) {
        todo!()
    }

    /// The next message to send; see [`ClientSession`](crate::ClientSession::poll_transmit). Encodes
    /// light, so measure it for [`note_encode`](Self::note_encode).
    pub fn poll_transmit(&mut self, _now: Duration) -> Option<Transmit> {
        todo!()
    }

    /// A message that need not arrive any more: newer light has replaced it.
    pub fn poll_cancel(&mut self) -> Option<TransmitId> {
        todo!()
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<ServerEvent> {
        todo!()
    }

    /// What the solver should apply next, if there is anything. Objects whose blobs are still on
    /// their way are left out until they are here.
    pub fn take_changes(&mut self) -> Option<(SnapshotId, Vec<SessionChange>)> {
        todo!()
    }

    /// Takes light over to be sent; `solve` is the time that it took. What it replaces is dropped.
    pub fn publish(&mut self, _now: Duration, _update: &LightingUpdate, _solve: Duration) {
        todo!()
    }

    /// The time that encoding took, for the next message.
    pub fn note_encode(&mut self, _time: Duration) {
        todo!()
    }

    /// When to call [`poll_transmit`](Self::poll_transmit) again although nothing happened.
    #[must_use]
    pub fn next_timeout(&self) -> Option<Duration> {
        todo!()
    }

    /// When the client was last heard of.
    #[must_use]
    pub fn last_heard(&self) -> Option<Duration> {
        let _ = &self.config;
        todo!()
    }
}
