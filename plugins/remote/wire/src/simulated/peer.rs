//! One end of a connection: what it has to send, what is under way, what has arrived.

use std::{
    collections::{BTreeMap, BTreeSet, VecDeque},
    sync::Arc,
    time::Duration,
};

use super::{IDLE, PACKET, air::Kind};
use crate::{Channel, CloseCode, Limits, LinkEvent, LinkStats, TransmitId, Wake};

/// The probe timeout before a round trip was measured (RFC 9002, 6.2.2: 333 ms, three times).
const FIRST_TIMEOUT: Duration = Duration::from_millis(999);
/// How long acknowledgements may take at most (RFC 9000, 18.2).
const ACK_DELAY: Duration = Duration::from_millis(25);

/// How far an end has got.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Phase {
    /// Not connected yet.
    Opening,
    /// Messages flow.
    Open,
    /// It has said goodbye, and repeats it for a while to whoever did not hear it.
    Closing { code: CloseCode, why: Arc<str>, until: Duration },
    /// Over, or gone without a word.
    Over,
}

/// A message that has not arrived for sure.
#[derive(Debug)]
pub(super) struct Outgoing {
    pub(super) id: Option<TransmitId>,
    pub(super) kind: Kind,
    pub(super) bytes: Arc<[u8]>,
    /// Pieces that have left at least once.
    pub(super) left: usize,
    /// Which pieces are known to have arrived, and how many are not.
    pub(super) arrived: Vec<bool>,
    pub(super) missing: usize,
    pub(super) cancelled: bool,
}

impl Outgoing {
    pub(super) fn pieces(&self) -> usize {
        self.arrived.len()
    }

    pub(super) fn piece_bytes(&self, index: usize) -> usize {
        self.bytes.len().saturating_sub(index * PACKET).min(PACKET)
    }
}

/// A packet under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    pub(super) key: u64,
    pub(super) index: usize,
    pub(super) bytes: usize,
    pub(super) sent: Duration,
    /// When it arrived; the sender doesn't know yet.
    pub(super) received: Option<Duration>,
}

/// A message that arrives.
#[derive(Debug)]
pub(super) struct Incoming {
    pub(super) has: Vec<bool>,
    pub(super) missing: usize,
}

/// One end.
pub(super) struct Peer {
    pub(super) phase: Phase,
    pub(super) limits: Limits,
    pub(super) wake: Option<Wake>,
    /// Whether somebody holds the link, or will.
    pub(super) held: bool,
    pub(super) events: VecDeque<LinkEvent>,
    pub(super) stats: LinkStats,

    /// Messages to send, in the order of their urgency: handshake, control, light, blobs.
    pub(super) queues: [VecDeque<u64>; 4],
    pub(super) outgoing: BTreeMap<u64, Outgoing>,
    pub(super) in_flight: BTreeMap<u64, Flight>,
    pub(super) in_flight_bytes: usize,
    pub(super) again: VecDeque<(u64, usize)>,
    pub(super) next_key: u64,
    pub(super) next_packet: u64,
    pub(super) next_order: [u64; 3],
    pub(super) largest_acked: Option<u64>,
    pub(super) line_free: Duration,
    pub(super) last_sent: Duration,
    srtt: Option<Duration>,
    variation: Duration,
    pub(super) timeouts: u32,

    pub(super) incoming: BTreeMap<u64, Incoming>,
    /// Messages that are complete: all below, and these.
    done_below: u64,
    done: BTreeSet<u64>,
    pub(super) next_control: u64,
    pub(super) early_control: BTreeMap<u64, Vec<u8>>,
    pub(super) last_heard: Duration,
}

impl Peer {
    pub(super) fn new(now: Duration, limits: Limits, wake: Option<Wake>) -> Self {
        Self {
            phase: Phase::Opening,
            limits,
            wake,
            held: true,
            events: VecDeque::new(),
            stats: LinkStats::default(),
            queues: Default::default(),
            outgoing: BTreeMap::new(),
            in_flight: BTreeMap::new(),
            in_flight_bytes: 0,
            again: VecDeque::new(),
            next_key: 0,
            next_packet: 0,
            next_order: [0; 3],
            largest_acked: None,
            line_free: Duration::ZERO,
            last_sent: now,
            srtt: None,
            variation: Duration::ZERO,
            timeouts: 0,
            incoming: BTreeMap::new(),
            done_below: 0,
            done: BTreeSet::new(),
            next_control: 0,
            early_control: BTreeMap::new(),
            last_heard: now,
        }
    }

    /// Queues a message.
    pub(super) fn push(&mut self, id: Option<TransmitId>, kind: Kind, bytes: Arc<[u8]>) {
        let key = self.next_key;
        self.next_key += 1;
        let pieces = bytes.len().div_ceil(PACKET).max(1);
        let arrived = vec![false; pieces];
        let message =
            Outgoing { id, kind, bytes, left: 0, arrived, missing: pieces, cancelled: false };
        self.outgoing.insert(key, message);
        let queue = match kind {
            Kind::Handshake(_) => 0,
            Kind::Message(Channel::Control, _) => 1,
            Kind::Message(Channel::Latest, _) => 2,
            Kind::Message(Channel::Bulk, _) => 3,
        };
        self.queues[queue].push_back(key);
    }

    /// Gives a message on [`Channel::Latest`] up: nothing more of it leaves.
    pub(super) fn cancel(&mut self, id: TransmitId) -> Option<u64> {
        let found = self.outgoing.iter_mut().find(|(_, message)| {
            message.id == Some(id) && matches!(message.kind, Kind::Message(Channel::Latest, _))
        });
        let (&key, message) = found?;
        message.cancelled = true;
        self.queues[2].retain(|queued| *queued != key);
        self.again.retain(|(again, _)| *again != key);
        Some(key)
    }

    /// Whether a message was given up and nothing of it is under way any more; forgets it then.
    pub(super) fn is_given_up(&mut self, key: u64) -> bool {
        let cancelled = self.outgoing.get(&key).is_some_and(|message| message.cancelled);
        let given_up = cancelled && !self.in_flight.values().any(|flight| flight.key == key);
        if given_up {
            self.outgoing.remove(&key);
        }
        given_up
    }

    /// Forgets packets under way whose pieces need not arrive any more; answers the messages that
    /// were given up.
    pub(super) fn forget_useless_flights(&mut self) -> Vec<u64> {
        let outgoing = &self.outgoing;
        let useful = |flight: &Flight| {
            let message = outgoing.get(&flight.key);
            message.is_some_and(|m| !m.cancelled && !m.arrived[flight.index])
        };
        let (mut given_up, mut freed) = (Vec::new(), 0);
        self.in_flight.retain(|_, flight| {
            let useful = useful(flight);
            if !useful {
                given_up.push(flight.key);
                freed += flight.bytes;
            }
            useful
        });
        self.in_flight_bytes -= freed;
        given_up.retain(|key| self.is_given_up(*key));
        given_up
    }

    /// A round trip was measured (RFC 9002, 5.3).
    pub(super) fn note_rtt(&mut self, sample: Duration) {
        match &mut self.srtt {
            None => {
                self.srtt = Some(sample);
                self.variation = sample / 2;
            }
            Some(srtt) => {
                self.variation = (self.variation * 3 + srtt.abs_diff(sample)) / 4;
                *srtt = (*srtt * 7 + sample) / 8;
            }
        }
        self.stats.rtt = self.srtt;
    }

    /// After so long, a packet before an acknowledged one is lost.
    pub(super) fn loss_delay(&self) -> Duration {
        (self.srtt.unwrap_or(FIRST_TIMEOUT) * 9 / 8).max(Duration::from_millis(1))
    }

    /// The probe timeout (RFC 9002, 6.2.1), doubled for each that has passed.
    pub(super) fn probe_delay(&self) -> Duration {
        let base = self.srtt.map_or(FIRST_TIMEOUT, |srtt| {
            srtt + (self.variation * 4).max(Duration::from_millis(1)) + ACK_DELAY
        });
        base * 2_u32.pow(self.timeouts.min(16))
    }

    /// The first packet before an acknowledged one that isn't lost yet: when it will be.
    pub(super) fn loss_deadline(&self) -> Option<Duration> {
        let largest = self.largest_acked?;
        let (_, oldest) = self.in_flight.range(..largest).next()?;
        Some(oldest.sent + self.loss_delay())
    }

    /// When a probe is due.
    pub(super) fn probe_deadline(&self) -> Option<Duration> {
        (!self.in_flight.is_empty()).then(|| self.last_sent + self.probe_delay())
    }

    /// When something happens by itself.
    pub(super) fn deadline(&self) -> Option<Duration> {
        match &self.phase {
            Phase::Over => None,
            Phase::Closing { until, .. } => Some(*until),
            Phase::Opening | Phase::Open => {
                let idle = self.last_heard + IDLE;
                [Some(idle), self.loss_deadline(), self.probe_deadline()]
                    .into_iter()
                    .flatten()
                    .min()
            }
        }
    }

    /// Whether a message is complete or will not come.
    pub(super) fn is_done(&self, key: u64) -> bool {
        key < self.done_below || self.done.contains(&key)
    }

    /// Notes that a message is complete or will not come.
    pub(super) fn set_done(&mut self, key: u64) {
        self.incoming.remove(&key);
        if key >= self.done_below {
            self.done.insert(key);
        }
        while self.done.remove(&self.done_below) {
            self.done_below += 1;
        }
    }

    /// Forgets all that was to be sent and all that was half received.
    pub(super) fn end(&mut self) {
        self.phase = Phase::Over;
        self.queues = Default::default();
        self.outgoing.clear();
        self.in_flight.clear();
        self.in_flight_bytes = 0;
        self.again.clear();
        self.incoming.clear();
        self.early_control.clear();
    }
}
