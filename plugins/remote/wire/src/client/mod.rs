//! The game's side of a session.

mod arrivals;
mod blobs;
mod flights;
mod history;
mod mirror;

use std::{cell::RefCell, collections::VecDeque, sync::Arc, time::Duration};

use farlight_gi_solver::session::{SessionChange, SessionSettings, SnapshotId};

use crate::{
    Channel, ClientHello, LightingMessage, Limits, SessionKey, Token, Transmit, TransmitId, View,
    Welcome, WireError,
    message::{ClientMessage, MAX_ACKS, ServerMessage},
    ping::Pinger,
};
use arrivals::Arrivals;
use blobs::Outgoing;
use flights::Flights;
use mirror::Mirror;

pub(crate) use blobs::CHUNK_BYTES;
pub(crate) use history::VERSIONS;

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
    /// Light. Texels and probes that a newer message has already brought are left out, and its
    /// snapshot never goes back.
    Lighting {
        /// The light.
        message: LightingMessage,
        /// How long the trip of its snapshot took, in the first message that shows it.
        trip: Option<Trip>,
    },
    /// The server says something that people should know.
    Notice(Arc<str>),
}

/// How long a snapshot and its answer were under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Trip {
    /// From the submission of its oldest change until the network had taken the snapshot over.
    pub send: Duration,
    /// On the network, both ways: from then until the light came, less the time on the server.
    pub transfer: Duration,
}

/// How far the scene has got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SyncState {
    /// Whether the server has let the client in (over the present connection).
    pub welcomed: bool,
    /// The newest snapshot that was submitted.
    pub submitted: SnapshotId,
    /// The newest snapshot that the server has, blobs aside.
    pub acknowledged: SnapshotId,
    /// Objects that changed and have not been sent.
    pub unsent_objects: usize,
    /// Bytes of blobs that the server asked for and that have not left.
    pub unsent_blob_bytes: u64,
    /// Whether everything that was submitted is with the server and nothing is under way.
    pub in_sync: bool,
    /// Round trip of the last ping.
    pub rtt: Option<Duration>,
    /// When something last came from the server; `None` while there is no connection.
    pub last_heard: Option<Duration>,
}

/// The game's side of a session. It outlives connections: after [`disconnected`](Self::disconnected)
/// and [`connected`](Self::connected) it sends what the server does not have.
#[derive(Debug)]
pub struct ClientSession {
    config: ClientConfig,
    mirror: Mirror,
    outgoing: Outgoing,
    arrivals: Arrivals,
    flights: Flights,
    pinger: Pinger,
    /// The session on the server, once it has let us in.
    key: Option<SessionKey>,
    settings: SessionSettings,
    connected: bool,
    welcomed: bool,
    queue: VecDeque<Vec<u8>>,
    /// Light to acknowledge.
    acks: Vec<u64>,
    resync: bool,
    view: Option<View>,
    /// The newest snapshot that was shown.
    shown: SnapshotId,
    converged: bool,
    events: VecDeque<ClientEvent>,
    next_id: u64,
}

impl ClientSession {
    /// A session that has no connection yet.
    #[must_use]
    pub fn new(config: ClientConfig) -> Self {
        Self {
            settings: config.settings.clone(),
            config,
            mirror: Mirror::default(),
            outgoing: Outgoing::default(),
            arrivals: Arrivals::default(),
            flights: Flights::default(),
            pinger: Pinger::default(),
            key: None,
            connected: false,
            welcomed: false,
            queue: VecDeque::new(),
            acks: Vec::new(),
            resync: false,
            view: None,
            shown: SnapshotId::default(),
            converged: false,
            events: VecDeque::new(),
            next_id: 0,
        }
    }

    /// Takes changes of the scene over; `snapshot` names the state after them and grows. Hashes
    /// meshes and images that it has not seen, so call it off the main thread.
    pub fn submit(&mut self, now: Duration, snapshot: SnapshotId, changes: Vec<SessionChange>) {
        self.mirror.submit(snapshot, changes);
        self.flights.submitted(now);
        self.converged = false;
    }

    /// Asks for all light again, for example after the textures were lost.
    pub fn resync(&mut self) {
        self.resync = true;
    }

    /// Tells where the client looks from.
    pub fn set_view(&mut self, view: View) {
        self.view = Some(view);
    }

    /// A link is open: greets.
    pub fn connected(&mut self, now: Duration) {
        self.disconnected();
        self.connected = true;
        self.pinger.start(now);
        let hello = ClientHello {
            name: self.config.name.clone(),
            token: self.config.token,
            resume: self.key,
            settings: self.config.settings.clone(),
        };
        self.queue.push_back(hello.encode());
    }

    /// The link is gone.
    pub fn disconnected(&mut self) {
        self.connected = false;
        self.welcomed = false;
        self.queue.clear();
        self.acks.clear();
        self.outgoing.forget();
        self.flights.forget();
        self.arrivals.reconnect();
        self.pinger = Pinger::default();
    }

    /// A message arrived.
    ///
    /// # Errors
    /// It doesn't fit; close the link with [`WireError::close_code`].
    pub fn receive(
        &mut self,
        now: Duration,
        channel: Channel,
        message: &[u8],
    ) -> Result<(), WireError> {
        WireError::check("a message", message.len(), channel.limit(&self.config.limits))?;
        if !self.connected {
            return Err(WireError::Unexpected("a message without a connection".into()));
        }
        self.pinger.heard(now);
        match (channel, self.welcomed) {
            (Channel::Control, false) => self.welcome(message),
            (Channel::Control, true) => self.control(now, message),
            (Channel::Latest, true) => self.light(now, message),
            (Channel::Latest, false) => {
                Err(WireError::Unexpected("light before the client has answered".into()))
            }
            (Channel::Bulk, _) => Err(WireError::Unexpected("a blob from the server".into())),
        }
    }

    fn welcome(&mut self, message: &[u8]) -> Result<(), WireError> {
        let welcome = Welcome::read(message)?;
        let resumed = welcome.resumed && self.key == Some(welcome.key);
        let asked = &self.config.settings;
        if welcome.settings.page_size != asked.page_size
            || welcome.settings.max_pages > asked.max_pages
        {
            return Err(WireError::invalid(
                "the welcome",
                "other lightmap pages than were asked for",
            ));
        }
        self.mirror.reconnect(resumed.then_some(welcome.snapshot));
        if !resumed {
            self.arrivals = Arrivals::default();
        }
        self.converged = false;
        self.key = Some(welcome.key);
        self.settings = welcome.settings.clone();
        self.welcomed = true;
        // The server sends light once it has heard that it is welcome.
        self.queue.push_back(ClientMessage::Acks(Vec::new()).encode());
        self.events.push_back(ClientEvent::Welcomed { resumed, settings: welcome.settings });
        Ok(())
    }

    fn control(&mut self, now: Duration, message: &[u8]) -> Result<(), WireError> {
        match ServerMessage::decode(message)? {
            None => {}
            Some(ServerMessage::Acknowledged(snapshot)) => self.mirror.acknowledge(snapshot),
            Some(ServerMessage::Wanted(blobs)) => {
                blobs.into_iter().for_each(|(hash, offset)| self.outgoing.want(hash, offset));
            }
            Some(ServerMessage::Notice(text)) => {
                self.events.push_back(ClientEvent::Notice(text.into()));
            }
            Some(ServerMessage::Ping(time)) => self.pinger.asked(time),
            Some(ServerMessage::Pong(time)) => self.pinger.answered(now, time),
        }
        Ok(())
    }

    fn light(&mut self, now: Duration, bytes: &[u8]) -> Result<(), WireError> {
        let bases = RefCell::new(Vec::new());
        let mut message =
            LightingMessage::decode_beside(bytes, &self.config.limits, |piece, sequence| {
                bases.borrow_mut().push((piece, sequence));
                self.arrivals.base(piece, sequence)
            })?;
        let Limits { objects, .. } = self.config.limits;
        let SessionSettings { page_size, max_pages, .. } = self.settings;
        self.arrivals.filter(&mut message, page_size, max_pages, objects)?;
        if !message.is_whole() {
            return Err(WireError::invalid("a lighting message", "it builds on what was not sent"));
        }
        self.arrivals.keep(&message, page_size, max_pages, self.mirror.probes());
        for (piece, sequence) in bases.into_inner() {
            self.arrivals.built_on(piece, sequence);
        }
        self.acks.push(message.sequence);
        if self.arrivals.is_newest(message.sequence) {
            self.converged =
                message.quality.converged && message.snapshot >= self.mirror.progress().0;
        }
        let trip = (message.snapshot > self.shown)
            .then(|| self.flights.answered(now, message.snapshot, &message.times))
            .flatten();
        self.shown = self.shown.max(message.snapshot.min(self.mirror.progress().0));
        message.snapshot = self.shown;
        self.events.push_back(ClientEvent::Lighting { message, trip });
        Ok(())
    }

    /// The network has taken a message over.
    pub fn sent(&mut self, now: Duration, id: TransmitId) {
        self.outgoing.sent(id);
        self.flights.sent(now, id);
    }

    /// The next message to send. Call it until it answers `None`, after everything that changes the
    /// session and at [`next_timeout`](Self::next_timeout).
    pub fn poll_transmit(&mut self, now: Duration) -> Option<Transmit> {
        if !self.connected {
            return None;
        }
        if let Some(message) = self.queue.pop_front() {
            return Some(self.transmit(Channel::Control, message));
        }
        if !self.welcomed {
            return None;
        }
        if let Some(message) = self.next_control(now) {
            return Some(self.transmit(Channel::Control, message.encode()));
        }
        if let Some(parts) = self.mirror.next_snapshot() {
            let snapshot = self.mirror.progress().0;
            let last_part = TransmitId(self.next_id + parts.len() as u64);
            self.flights.departed(now, snapshot, last_part);
            self.queue.extend(parts.into_iter().map(|p| ClientMessage::Snapshot(p).encode()));
            let message = self.queue.pop_front()?;
            return Some(self.transmit(Channel::Control, message));
        }
        let message = self.outgoing.next(&self.mirror)?;
        let transmit = self.transmit(message.channel(), message.encode());
        if transmit.channel == Channel::Bulk {
            self.outgoing.transmitted(transmit.id);
        }
        Some(transmit)
    }

    fn next_control(&mut self, now: Duration) -> Option<ClientMessage> {
        if !self.acks.is_empty() {
            let rest = self.acks.split_off(self.acks.len().min(MAX_ACKS));
            return Some(ClientMessage::Acks(std::mem::replace(&mut self.acks, rest)));
        }
        if let Some(time) = self.pinger.answer() {
            return Some(ClientMessage::Pong(time));
        }
        if std::mem::take(&mut self.resync) {
            return Some(ClientMessage::Resync);
        }
        if let Some(view) = self.view.take() {
            return Some(ClientMessage::View(view));
        }
        self.pinger.due(now, self.is_busy()).map(ClientMessage::Ping)
    }

    /// Whether something is expected from the server.
    fn is_busy(&self) -> bool {
        let waits_for_light = !self.converged && self.mirror.progress().0 > SnapshotId(0);
        waits_for_light || !self.mirror.in_sync() || !self.outgoing.is_empty()
    }

    fn transmit(&mut self, channel: Channel, message: Vec<u8>) -> Transmit {
        self.next_id += 1;
        Transmit { id: TransmitId(self.next_id), channel, message }
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<ClientEvent> {
        self.events.pop_front()
    }

    /// When to call [`poll_transmit`](Self::poll_transmit) again although nothing happened.
    #[must_use]
    pub fn next_timeout(&self) -> Option<Duration> {
        self.welcomed.then(|| self.pinger.next(self.is_busy()))
    }

    /// How far the scene has got.
    #[must_use]
    pub fn state(&self) -> SyncState {
        let (submitted, acknowledged) = self.mirror.progress();
        SyncState {
            welcomed: self.welcomed,
            submitted,
            acknowledged,
            unsent_objects: self.mirror.unsent(),
            unsent_blob_bytes: self.outgoing.unsent_bytes(&self.mirror),
            in_sync: self.mirror.in_sync() && self.outgoing.is_empty(),
            rtt: self.pinger.rtt(),
            last_heard: self.pinger.last_heard(),
        }
    }

    /// Whether the server has said that the newest snapshot is solved as well as it will be.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.converged && self.mirror.in_sync()
    }
}
