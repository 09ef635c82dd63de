//! Links of a simulated network, and who makes them.

use std::{fmt, sync::Arc};

use super::{
    Network,
    air::{Kind, Side},
    connection::{Connection, Outcome},
    network::State,
    peer::Phase,
};
use crate::{
    CloseCode, Connector, Limits, Link, LinkEvent, LinkStats, Listener, Transmit, TransmitId, Wake,
};

/// An end of a connection of a [`Network`]. Dropping it without [`Link::close`] is the end of a
/// process that is killed: the other end hears nothing more.
pub struct SimulatedLink {
    pub(super) network: Network,
    pub(super) connection: u64,
    pub(super) side: Side,
}

impl fmt::Debug for SimulatedLink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SimulatedLink").field("side", &self.side).finish_non_exhaustive()
    }
}

impl SimulatedLink {
    fn with<T>(
        &self,
        act: impl FnOnce(&mut Connection, &mut super::air::Air, &mut Outcome) -> T,
    ) -> Option<T> {
        let mut out = Outcome::default();
        let mut state = self.network.lock();
        let State { air, connections, .. } = &mut *state;
        let result = connections.get_mut(&self.connection).map(|c| act(c, air, &mut out));
        drop(state);
        out.wakes.iter().for_each(|wake| wake());
        result
    }
}

impl Link for SimulatedLink {
    fn send(&mut self, transmit: Transmit) {
        self.with(|connection, air, out| connection.send(self.side, transmit, air, out));
    }

    fn cancel(&mut self, id: TransmitId) {
        self.with(|connection, air, out| {
            connection.cancel(self.side, id);
            connection.pump(self.side, air, out);
        });
    }

    fn poll(&mut self) -> Option<LinkEvent> {
        self.with(|connection, _, _| connection.peer(self.side)?.events.pop_front())?
    }

    fn close(&mut self, code: CloseCode, reason: &str) {
        self.with(|connection, air, out| {
            connection.close(self.side, code, reason, air, out);
            if let Some(peer) = connection.peer(self.side) {
                peer.events.clear();
            }
        });
    }

    fn stats(&self) -> LinkStats {
        let stats = self.with(|connection, _, _| connection.peer(self.side).map(|p| p.stats));
        stats.flatten().unwrap_or_default()
    }
}

impl Drop for SimulatedLink {
    fn drop(&mut self) {
        self.with(|connection, _, _| {
            if let Some(peer) = connection.peer(self.side) {
                peer.held = false;
                peer.wake = None;
                if matches!(peer.phase, Phase::Opening | Phase::Open) {
                    peer.end();
                }
            }
        });
    }
}

/// Connects to whoever listens on a [`Network`].
#[derive(Clone, Debug)]
pub struct SimulatedConnector {
    pub(super) network: Network,
}

impl Connector for SimulatedConnector {
    fn connect(&mut self, limits: &Limits, wake: Wake) -> Box<dyn Link> {
        let connection = self.network.lock().connect(limits, wake);
        let link = SimulatedLink { network: self.network.clone(), connection, side: Side::Client };
        link.with(|connection, air, out| {
            connection.client.push(None, Kind::Handshake(0), Arc::from([0_u8; 1200]));
            connection.pump(Side::Client, air, out);
        });
        Box::new(link)
    }

    fn peer(&self) -> String {
        "the simulated network".to_owned()
    }
}

/// Takes connections of a [`Network`]. When it is dropped nobody does; links that it made go on.
#[derive(Debug)]
pub struct SimulatedListener {
    pub(super) network: Network,
    pub(super) id: u64,
}

impl Listener for SimulatedListener {
    fn accept(&mut self) -> Option<(Box<dyn Link>, String)> {
        let mut state = self.network.lock();
        let server = state.server.as_mut().filter(|server| server.id == self.id)?;
        let connection = server.waiting.pop_front()?;
        drop(state);
        let link = SimulatedLink { network: self.network.clone(), connection, side: Side::Server };
        Some((Box::new(link), format!("simulated client {connection}")))
    }

    fn set_wake(&mut self, wake: Wake) {
        let mut state = self.network.lock();
        let State { connections, server, .. } = &mut *state;
        let Some(server) = server.as_mut().filter(|server| server.id == self.id) else { return };
        for peer in connections.values_mut().filter_map(|c| c.server.as_mut()) {
            if peer.held {
                peer.wake = Some(wake.clone());
            }
        }
        let waiting = !server.waiting.is_empty();
        server.wake = Some(wake.clone());
        drop(state);
        if waiting {
            wake();
        }
    }
}

impl Drop for SimulatedListener {
    fn drop(&mut self) {
        let mut state = self.network.lock();
        if state.server.as_ref().is_some_and(|server| server.id == self.id) {
            state.stop_listening();
        }
    }
}
