//! Two ends of links, driven by hand.

#![expect(dead_code, reason = "every test binary uses a part of it")]

pub(crate) mod proxy;
pub(crate) mod raw;

use std::{
    net::SocketAddr,
    sync::{Arc, Condvar, Mutex},
    time::{Duration, Instant},
};

use farlight_quic::{Authority, ListenConfig, QuicConnector, QuicListener};
use farlight_wire::{
    Channel, Closed, Connector, Invitation, Limits, Link, LinkEvent, Listener, Transmit,
    TransmitId, Wake,
};

/// Only a guard against hanging.
pub(crate) const PATIENCE: Duration = Duration::from_secs(30);

/// Sleeps until woken.
#[derive(Default)]
pub(crate) struct Bell(Mutex<bool>, Condvar);

impl Bell {
    pub(crate) fn wake(self: &Arc<Self>) -> Wake {
        let bell = Arc::clone(self);
        Arc::new(move || {
            *bell.0.lock().unwrap() = true;
            bell.1.notify_all();
        })
    }

    pub(crate) fn wait(&self, limit: Duration) {
        let rung = self.0.lock().unwrap();
        let (mut rung, _) = self.1.wait_timeout_while(rung, limit, |rung| !*rung).unwrap();
        *rung = false;
    }
}

/// One end of a link.
pub(crate) struct End {
    pub(crate) link: Box<dyn Link>,
    bell: Arc<Bell>,
    next: u64,
}

impl End {
    /// The next event within a time.
    pub(crate) fn event_within(&mut self, limit: Duration) -> Option<LinkEvent> {
        let start = Instant::now();
        loop {
            if let Some(event) = self.link.poll() {
                return Some(event);
            }
            let left = limit.checked_sub(start.elapsed())?;
            self.bell.wait(left.min(Duration::from_millis(100)));
        }
    }

    pub(crate) fn event(&mut self) -> LinkEvent {
        self.event_within(PATIENCE).expect("an event")
    }

    pub(crate) fn opened(&mut self) {
        assert_eq!(self.event(), LinkEvent::Opened);
    }

    /// The next message, past confirmations.
    pub(crate) fn message(&mut self) -> (Channel, Vec<u8>) {
        loop {
            match self.event() {
                LinkEvent::Received(channel, message) => return (channel, message),
                LinkEvent::Sent(_) | LinkEvent::Opened => {}
                LinkEvent::Closed(closed) => panic!("{closed}"),
            }
        }
    }

    /// How it ends, past everything else.
    pub(crate) fn closed(&mut self) -> Closed {
        loop {
            if let LinkEvent::Closed(closed) = self.event() {
                return closed;
            }
        }
    }

    pub(crate) fn send(&mut self, channel: Channel, message: Vec<u8>) -> TransmitId {
        self.next += 1;
        let id = TransmitId(self.next);
        self.link.send(Transmit { id, channel, message });
        id
    }

    /// Waits until a message was taken over; no message may arrive meanwhile.
    pub(crate) fn sent(&mut self, id: TransmitId) {
        loop {
            match self.event() {
                LinkEvent::Sent(sent) if sent == id => return,
                LinkEvent::Sent(_) | LinkEvent::Opened => {}
                other => panic!("{other:?}"),
            }
        }
    }
}

/// A listener with a bell.
pub(crate) struct Host {
    pub(crate) listener: QuicListener,
    pub(crate) authority: Arc<Authority>,
    bell: Arc<Bell>,
}

impl Host {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self::with(Arc::new(Authority::open(folder.path()).unwrap()), |_| {})
    }

    pub(crate) fn with(authority: Arc<Authority>, change: impl FnOnce(&mut ListenConfig)) -> Self {
        let address = SocketAddr::from(([127, 0, 0, 1], 0));
        let mut config = ListenConfig::new(address, Arc::clone(&authority));
        change(&mut config);
        let mut listener = QuicListener::bind(config).unwrap();
        let bell = Arc::new(Bell::default());
        listener.set_wake(bell.wake());
        Self { listener, authority, bell }
    }

    pub(crate) fn invitation(&self) -> Invitation {
        self.invitation_at(self.listener.local_addr())
    }

    /// As if the server were somewhere else.
    pub(crate) fn invitation_at(&self, address: SocketAddr) -> Invitation {
        Invitation {
            host: address.ip().to_string(),
            port: address.port(),
            token: self.authority.token(),
            authority: self.authority.fingerprint(),
        }
    }

    pub(crate) fn accept_within(&mut self, limit: Duration) -> Option<End> {
        let start = Instant::now();
        loop {
            if let Some((link, _)) = self.listener.accept() {
                return Some(End { link, bell: Arc::clone(&self.bell), next: 0 });
            }
            let left = limit.checked_sub(start.elapsed())?;
            self.bell.wait(left.min(Duration::from_millis(100)));
        }
    }

    pub(crate) fn accept(&mut self) -> End {
        self.accept_within(PATIENCE).expect("a client")
    }
}

pub(crate) fn connect(invitation: &Invitation, limits: &Limits) -> End {
    let bell = Arc::new(Bell::default());
    let link = QuicConnector::new(invitation).connect(limits, bell.wake());
    End { link, bell, next: 0 }
}

/// A host and the two ends of an open link.
pub(crate) fn pair() -> (Host, End, End) {
    let mut host = Host::new();
    let (client, server) = join(&mut host);
    (host, client, server)
}

pub(crate) fn join(host: &mut Host) -> (End, End) {
    let mut client = connect(&host.invitation(), &Limits::default());
    client.opened();
    let mut server = host.accept();
    server.opened();
    (client, server)
}

/// Bytes that depend on a seed.
pub(crate) fn noise(seed: u64, length: usize) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let next = |_| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    };
    (0..length).map(next).collect()
}
