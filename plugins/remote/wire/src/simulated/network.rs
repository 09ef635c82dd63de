//! The network that links share.

use std::{
    collections::{BTreeMap, VecDeque},
    fmt,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use super::{
    Counters, LinkConditions, SimulatedConnector, SimulatedLink, SimulatedListener,
    air::{Air, Datagram, Flying, Kind, Side},
    connection::{Connection, Outcome},
    peer::{Peer, Phase},
};
use crate::{Limits, Wake};

/// A network between clients and at most one server at a time. Clones are the same network.
///
/// Nothing happens by itself: [`advance`](Self::advance) lets time pass. Links wake their owners
/// from within it.
#[derive(Clone)]
pub struct Network(pub(super) Arc<Mutex<State>>);

pub(super) struct State {
    pub(super) air: Air,
    pub(super) connections: BTreeMap<u64, Connection>,
    next_connection: u64,
    pub(super) server: Option<Server>,
    next_server: u64,
}

/// Who takes connections.
pub(super) struct Server {
    pub(super) id: u64,
    pub(super) limits: Limits,
    pub(super) wake: Option<Wake>,
    /// Connections to accept.
    pub(super) waiting: VecDeque<u64>,
}

impl fmt::Debug for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Network").finish_non_exhaustive()
    }
}

impl Network {
    /// A network whose chance is drawn from a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(Arc::new(Mutex::new(State {
            air: Air::new(seed),
            connections: BTreeMap::new(),
            next_connection: 0,
            server: None,
            next_server: 0,
        })))
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How it behaves from now on.
    pub fn set_conditions(&self, conditions: LinkConditions) {
        self.lock().air.conditions = conditions;
    }

    /// Cuts the line, or mends it. What arrives or leaves while it is cut is lost.
    pub fn set_down(&self, down: bool) {
        let mut state = self.lock();
        state.air.down = down;
        state.air.down_until = Duration::ZERO;
    }

    /// Cuts the line until a time.
    pub fn set_down_until(&self, time: Duration) {
        self.lock().air.down_until = time;
    }

    /// Its time.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.lock().air.now
    }

    /// What it has carried.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.lock().air.counters
    }

    /// When something happens next, if nobody sends: the time to [`advance`](Self::advance) to.
    #[must_use]
    pub fn next_event(&self) -> Option<Duration> {
        self.lock().next_event()
    }

    /// Lets time pass. Goes back never: an earlier `now` counts as the present.
    pub fn advance(&self, now: Duration) {
        loop {
            let mut out = Outcome::default();
            let mut state = self.lock();
            let next = state.next_event().filter(|next| *next <= now);
            state.air.now = state.air.now.max(next.unwrap_or(now));
            if next.is_some() {
                state.step(&mut out);
            }
            drop(state);
            out.wakes.iter().for_each(|wake| wake());
            if next.is_none() {
                return;
            }
        }
    }

    /// Connects to whoever listens at that time.
    #[must_use]
    pub fn connector(&self) -> SimulatedConnector {
        SimulatedConnector { network: self.clone() }
    }

    /// Listens, in place of whoever did; the former listener takes no more connections.
    #[must_use]
    pub fn listener(&self, limits: &Limits) -> SimulatedListener {
        let mut state = self.lock();
        state.next_server += 1;
        let id = state.next_server;
        state.stop_listening();
        state.server = Some(Server { id, limits: *limits, wake: None, waiting: VecDeque::new() });
        drop(state);
        SimulatedListener { network: self.clone(), id }
    }

    /// A link whose ends are open already.
    #[must_use]
    pub fn pair(&self, limits: &Limits, wakes: [Wake; 2]) -> [SimulatedLink; 2] {
        let mut state = self.lock();
        let [client, server] = wakes;
        let id = state.connect(limits, client);
        let now = state.air.now;
        if let Some(connection) = state.connections.get_mut(&id) {
            connection.server = Some(Peer::new(now, *limits, Some(server)));
            for side in Side::BOTH {
                connection.open(side, &mut Outcome::default());
            }
        }
        drop(state);
        Side::BOTH.map(|side| SimulatedLink { network: self.clone(), connection: id, side })
    }
}

impl State {
    /// Makes a client's end that has sent nothing yet.
    pub(super) fn connect(&mut self, limits: &Limits, wake: Wake) -> u64 {
        self.next_connection += 1;
        let id = self.next_connection;
        self.air.counters.connections += 1;
        let client = Peer::new(self.air.now, *limits, Some(wake));
        self.connections.insert(id, Connection { id, client, server: None });
        id
    }

    fn next_event(&self) -> Option<Duration> {
        let timers = self.connections.values().filter_map(Connection::deadline).min();
        let next = [self.air.next_arrival(), timers].into_iter().flatten().min();
        next.map(|next| next.max(self.air.now))
    }

    /// What happens now: one datagram arrives, or timers fire.
    fn step(&mut self, out: &mut Outcome) {
        if let Some(Flying { connection, to, datagram, .. }) = self.air.land() {
            self.make_server_end(connection, to, &datagram);
            if let Some(found) = self.connections.get_mut(&connection) {
                found.arrive(to, datagram, &mut self.air, out);
            }
            if std::mem::take(&mut out.accepted)
                && let Some(server) = &mut self.server
            {
                server.waiting.push_back(connection);
                out.wakes.extend(server.wake.clone());
            }
            return;
        }
        for connection in self.connections.values_mut() {
            if connection.deadline().is_some_and(|deadline| deadline <= self.air.now) {
                for side in Side::BOTH {
                    connection.time(side, &mut self.air, out);
                }
            }
        }
        self.connections.retain(|_, connection| !connection.is_over());
    }

    /// A client's first datagram makes the other end, if there is a server.
    fn make_server_end(&mut self, connection: u64, to: Side, datagram: &Datagram) {
        let first = matches!(datagram, Datagram::Data { kind: Kind::Handshake(0), .. });
        if let (true, Side::Server, Some(server), Some(connection)) =
            (first, to, &self.server, self.connections.get_mut(&connection))
            && connection.server.is_none()
        {
            let peer = Peer::new(self.air.now, server.limits, server.wake.clone());
            connection.server = Some(peer);
        }
    }

    /// Connections that wait for a listener which is gone are gone too.
    pub(super) fn stop_listening(&mut self) {
        let Some(server) = self.server.take() else { return };
        for connection in self.connections.values_mut() {
            let waits = server.waiting.contains(&connection.id);
            if let Some(peer) = &mut connection.server
                && (waits || peer.phase == Phase::Opening)
            {
                peer.end();
                peer.held = false;
            }
        }
    }
}
