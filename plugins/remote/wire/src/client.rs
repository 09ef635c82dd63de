//! The game's side of a session.

use std::{sync::Arc, time::Duration};

use farlight_gi_solver::session::{SessionChange, SessionSettings, SnapshotId};

use crate::{Channel, LightingMessage, Limits, Token, Transmit, TransmitId, View, WireError};

/// What a client session is made with.
#[derive(Clone, Debug)]
pub struct ClientConfig {
    /// What the server's log calls it.
    pub name: String,
    /// Lets it in.
    pub token: Token,
    /// How lighting should be solved; the server may lower some of it.
    pub settings: SessionSettings,
    /// Bounds of what it takes.
    pub limits: Limits,
}

/// What a client session has to tell.
#[derive(Clone, Debug)]
pub enum ClientEvent {
    /// The server let it in.
    Welcomed {
        /// Whether it still has the session, so that only changes are sent.
        resumed: bool,
        /// How lighting is solved.
        settings: SessionSettings,
    },
    /// Light. Texels and probes that a newer message has already brought are left out.
    Lighting {
        /// The light.
        message: LightingMessage,
        /// From the submission of its snapshot until the network had taken it over.
        send: Duration,
        /// On the network, both ways: from the submission to now, less what other stages took.
        transfer: Duration,
    },
    /// The server says something that people should know.
    Notice(Arc<str>),
}

/// How far the scene has got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SyncState {
    /// Whether the server has let the client in (over the present connection).
    pub welcomed: bool,
    /// The newest snapshot that was submitted.
    pub submitted: SnapshotId,
    /// The newest snapshot that the server has.
    pub acknowledged: SnapshotId,
    /// Objects that changed and have not been sent.
    pub unsent_objects: usize,
    /// Bytes of blobs that the server asked for and that have not left.
    pub unsent_blob_bytes: u64,
    /// Whether everything that was submitted is with the server and nothing is under way.
    pub in_sync: bool,
    /// Round trip of the last ping.
    pub rtt: Option<Duration>,
    /// Since when nothing has come from the server; `None` while there is no connection.
    pub last_heard: Option<Duration>,
}

/// The game's side of a session. It outlives connections: after [`disconnected`](Self::disconnected)
/// and [`connected`](Self::connected) it sends what the server does not have.
#[derive(Debug)]
pub struct ClientSession {
    config: ClientConfig,
}

impl ClientSession {
    /// A session that has no connection yet.
    #[must_use]
    pub fn new(config: ClientConfig) -> Self {
        Self { config }
    }

    /// Takes changes of the scene over; `snapshot` names the state after them and grows. Hashes
    /// meshes and images that it has not seen, so call it off the main thread.
    pub fn submit(&mut self, _now: Duration, _snapshot: SnapshotId, _changes: Vec<SessionChange>) {
        todo!()
    }

    /// Asks for all light again, for example after the textures were lost.
    pub fn resync(&mut self) {
        todo!()
    }

    /// Tells where the client looks from.
    pub fn set_view(&mut self, _view: View) {
        todo!()
    }

    /// A link is open: greets.
    pub fn connected(&mut self, _now: Duration) {
        todo!()
    }

    /// The link is gone.
    pub fn disconnected(&mut self) {
        todo!()
    }

    /// A message arrived.
    ///
    /// # Errors
    /// It doesn't fit; close the link with [`CloseCode::Protocol`](crate::CloseCode::Protocol).
    pub fn receive(
        &mut self,
        _now: Duration,
        _channel: Channel,
        _message: &[u8],
    ) -> Result<(), WireError> {
        todo!()
    }

    /// The network has taken a message over.
    pub fn sent(&mut self, _now: Duration, _id: TransmitId) {
        todo!()
    }

    /// The next message to send. Call it until it answers `None`, after everything that changes the
    /// session and at [`next_timeout`](Self::next_timeout).
    pub fn poll_transmit(&mut self, _now: Duration) -> Option<Transmit> {
        todo!()
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<ClientEvent> {
        todo!()
    }

    /// When to call [`poll_transmit`](Self::poll_transmit) again although nothing happened.
    #[must_use]
    pub fn next_timeout(&self) -> Option<Duration> {
        todo!()
    }

    /// How far the scene has got.
    #[must_use]
    pub fn state(&self) -> SyncState {
        let _ = &self.config;
        todo!()
    }
}
