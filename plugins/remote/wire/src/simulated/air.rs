//! What lies between the ends: packets on their way, chance, and what was carried.

use std::{cmp::Reverse, collections::BinaryHeap, sync::Arc, time::Duration};

use farlight_gi_solver::sampling::Rng;

use super::{Counters, LinkConditions, OVERHEAD};
use crate::{Channel, CloseCode};

/// One end of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Side {
    Client,
    Server,
}

impl Side {
    pub(super) const BOTH: [Self; 2] = [Self::Client, Self::Server];

    pub(super) fn other(self) -> Self {
        match self {
            Self::Client => Self::Server,
            Self::Server => Self::Client,
        }
    }
}

/// What a message is to the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Four of them open a link: two round trips, as for QUIC and WebTransport on top.
    Handshake(u8),
    /// With its place in the order of its channel.
    Message(Channel, u64),
}

/// What travels in one piece.
#[derive(Clone, Debug)]
pub(super) enum Datagram {
    /// A piece of a message, or all of it.
    Data { number: u64, key: u64, kind: Kind, index: usize, pieces: usize, bytes: Arc<[u8]> },
    /// Acknowledges all packets that had arrived at this time.
    Ack { at: Duration },
    /// Goodbye.
    Close { code: CloseCode, why: Arc<str> },
}

/// A datagram on its way.
#[derive(Debug)]
pub(super) struct Flying {
    pub(super) arrival: Duration,
    /// Keeps the order of those that arrive at the same time.
    order: u64,
    pub(super) connection: u64,
    pub(super) to: Side,
    pub(super) datagram: Datagram,
}

impl PartialEq for Flying {
    fn eq(&self, other: &Self) -> bool {
        (self.arrival, self.order) == (other.arrival, other.order)
    }
}

impl Eq for Flying {}

impl PartialOrd for Flying {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Flying {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.arrival, self.order).cmp(&(other.arrival, other.order))
    }
}

/// The air.
#[derive(Debug)]
pub(super) struct Air {
    pub(super) now: Duration,
    pub(super) conditions: LinkConditions,
    /// The line is cut: for ever, and until a time.
    pub(super) down: bool,
    pub(super) down_until: Duration,
    pub(super) counters: Counters,
    flying: BinaryHeap<Reverse<Flying>>,
    rng: Rng,
    sent: u64,
}

impl Air {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            now: Duration::ZERO,
            conditions: LinkConditions::default(),
            down: false,
            down_until: Duration::ZERO,
            counters: Counters::default(),
            flying: BinaryHeap::new(),
            rng: Rng::new(seed, 0x11f7),
            sent: 0,
        }
    }

    pub(super) fn is_down(&self) -> bool {
        self.down || self.now < self.down_until
    }

    /// Sends a datagram that leaves at `departure` (not before now).
    pub(super) fn send(
        &mut self,
        connection: u64,
        to: Side,
        departure: Duration,
        datagram: Datagram,
    ) {
        let LinkConditions { delay, jitter, loss, reorder, .. } = self.conditions;
        // The same numbers are drawn whatever happens, so that a run changes little with one of
        // the conditions.
        let (lost, late, extra) =
            (self.rng.next_f32() < loss, self.rng.next_f32() < reorder, self.rng.next_f32());
        self.counters.packets += 1;
        if lost || self.is_down() {
            self.counters.lost_packets += 1;
            return;
        }
        let late = if late { delay / 2 } else { Duration::ZERO };
        let arrival = departure.max(self.now) + delay + late + jitter.mul_f32(extra);
        self.sent += 1;
        let order = self.sent;
        self.flying.push(Reverse(Flying { arrival, order, connection, to, datagram }));
    }

    /// When the next datagram arrives.
    pub(super) fn next_arrival(&self) -> Option<Duration> {
        self.flying.peek().map(|flying| flying.0.arrival)
    }

    /// The next datagram that arrives now; those that arrive while the line is cut are lost.
    pub(super) fn land(&mut self) -> Option<Flying> {
        while self.next_arrival()? <= self.now {
            let Reverse(flying) = self.flying.pop()?;
            if !self.is_down() {
                return Some(flying);
            }
            self.counters.lost_packets += 1;
        }
        None
    }

    /// How long the line takes for bytes of one packet.
    pub(super) fn serialization(&self, bytes: usize) -> Duration {
        match self.conditions.bandwidth {
            Some(rate) => Duration::from_secs_f64((bytes + OVERHEAD) as f64 / rate.max(1) as f64),
            None => Duration::ZERO,
        }
    }
}
