//! A connection: two ends, and what happens when datagrams arrive and time passes.

use std::{sync::Arc, time::Duration};

use super::{
    air::{Air, Datagram, Kind, Side},
    index,
    peer::{Flight, Incoming, Peer, Phase},
};
use crate::{Channel, CloseCode, Closed, LinkEvent, Transmit, TransmitId, Wake};

/// Two ends.
pub(super) struct Connection {
    pub(super) id: u64,
    pub(super) client: Peer,
    /// `None` until the first datagram has reached a server.
    pub(super) server: Option<Peer>,
}

/// What became of a connection.
#[derive(Default)]
pub(super) struct Outcome {
    /// To be called without a lock.
    pub(super) wakes: Vec<Wake>,
    /// The server's end can be accepted.
    pub(super) accepted: bool,
}

impl Connection {
    pub(super) fn peer(&mut self, side: Side) -> Option<&mut Peer> {
        match side {
            Side::Client => Some(&mut self.client),
            Side::Server => self.server.as_mut(),
        }
    }

    /// Whether both ends are over and nobody waits for events.
    pub(super) fn is_over(&self) -> bool {
        let over = |peer: &Peer| peer.phase == Phase::Over && !peer.held;
        over(&self.client) && self.server.as_ref().is_none_or(over)
    }

    /// When something happens by itself.
    pub(super) fn deadline(&self) -> Option<Duration> {
        let server = self.server.as_ref().and_then(Peer::deadline);
        [self.client.deadline(), server].into_iter().flatten().min()
    }

    /// A link gives a message up.
    pub(super) fn cancel(&mut self, side: Side, id: TransmitId) {
        let Some(peer) = self.peer(side) else { return };
        if let Some(key) = peer.cancel(id)
            && peer.is_given_up(key)
        {
            self.give_up(side, &[key]);
        }
    }

    /// A link sends.
    pub(super) fn send(
        &mut self,
        side: Side,
        transmit: Transmit,
        air: &mut Air,
        out: &mut Outcome,
    ) {
        let Some(peer) = self.peer(side) else { return };
        if !matches!(peer.phase, Phase::Opening | Phase::Open) {
            return;
        }
        let order = &mut peer.next_order[index(transmit.channel)];
        let kind = Kind::Message(transmit.channel, *order);
        *order += 1;
        peer.push(Some(transmit.id), kind, transmit.message.into());
        self.pump(side, air, out);
    }

    /// Sends what the window takes.
    pub(super) fn pump(&mut self, side: Side, air: &mut Air, out: &mut Outcome) {
        loop {
            let window = air.conditions.window;
            let Some(peer) = self.peer(side) else { return };
            let open = peer.phase == Phase::Open;
            let piece = if let Some(&(key, piece)) = peer.again.front() {
                if !fits(peer, key, piece, window) {
                    return;
                }
                peer.again.pop_front();
                (key, piece)
            } else {
                let queues = if open { 0..4 } else { 0..1 };
                let queue = queues.into_iter().find(|q| !peer.queues[*q].is_empty());
                let Some(queue) = queue else { return };
                let Some(&key) = peer.queues[queue].front() else { return };
                let Some(message) = peer.outgoing.get(&key) else {
                    peer.queues[queue].pop_front();
                    continue;
                };
                let piece = message.left;
                if !fits(peer, key, piece, window) {
                    return;
                }
                self.leave(side, queue, key, air, out);
                (key, piece)
            };
            self.transmit(side, piece.0, piece.1, air);
        }
    }

    /// Notes that the next piece of a message leaves for the first time.
    fn leave(&mut self, side: Side, queue: usize, key: u64, air: &mut Air, out: &mut Outcome) {
        let Some(peer) = self.peer(side) else { return };
        let Some(message) = peer.outgoing.get_mut(&key) else { return };
        message.left += 1;
        if message.left < message.pieces() {
            return;
        }
        peer.queues[queue].pop_front();
        if let (Some(id), Kind::Message(channel, _)) = (message.id, message.kind) {
            let bytes = message.bytes.len() as u64;
            peer.stats.sent_bytes += bytes;
            peer.events.push_back(LinkEvent::Sent(id));
            out.wakes.extend(peer.wake.clone());
            let counters = &mut air.counters;
            let traffic = match side {
                Side::Client => &mut counters.up[index(channel)],
                Side::Server => &mut counters.down[index(channel)],
            };
            traffic.messages += 1;
            traffic.bytes += bytes;
        }
    }

    fn transmit(&mut self, side: Side, key: u64, index: usize, air: &mut Air) {
        let id = self.id;
        let Some(peer) = self.peer(side) else { return };
        let Some(message) = peer.outgoing.get(&key) else { return };
        if message.cancelled || message.arrived[index] {
            return;
        }
        let (kind, pieces, bytes) = (message.kind, message.pieces(), message.bytes.clone());
        let size = message.piece_bytes(index);
        let number = peer.next_packet;
        peer.next_packet += 1;
        let departure = peer.line_free.max(air.now);
        peer.line_free = departure + air.serialization(size);
        peer.last_sent = departure;
        peer.in_flight_bytes += size;
        let flight = Flight { key, index, bytes: size, sent: departure, received: None };
        peer.in_flight.insert(number, flight);
        let leaves = peer.line_free;
        let datagram = Datagram::Data { number, key, kind, index, pieces, bytes };
        air.send(id, side.other(), leaves, datagram);
    }

    /// A datagram arrives.
    pub(super) fn arrive(
        &mut self,
        to: Side,
        datagram: Datagram,
        air: &mut Air,
        out: &mut Outcome,
    ) {
        let id = self.id;
        let Some(peer) = self.peer(to) else { return };
        match &peer.phase {
            Phase::Over => return,
            Phase::Closing { code, why, .. } => {
                let close = Datagram::Close { code: *code, why: why.clone() };
                air.send(id, to.other(), air.now, close);
                return;
            }
            Phase::Opening | Phase::Open => {}
        }
        peer.last_heard = air.now;
        match datagram {
            Datagram::Data { number, key, kind, index, pieces, bytes } => {
                self.receive_piece(to, key, kind, index, pieces, &bytes, air, out);
                if let Some(sender) = self.peer(to.other())
                    && let Some(flight) = sender.in_flight.get_mut(&number)
                {
                    flight.received = Some(air.now);
                }
                air.send(id, to.other(), air.now, Datagram::Ack { at: air.now });
            }
            Datagram::Ack { at } => {
                self.acknowledge(to, at, air);
                self.detect_losses(to, air);
                self.pump(to, air, out);
            }
            Datagram::Close { code, why } => self.end(to, Closed::Goodbye(code, why), out),
        }
    }

    fn receive_piece(
        &mut self,
        to: Side,
        key: u64,
        kind: Kind,
        index: usize,
        pieces: usize,
        bytes: &Arc<[u8]>,
        air: &mut Air,
        out: &mut Outcome,
    ) {
        let Some(peer) = self.peer(to) else { return };
        if peer.is_done(key) {
            return;
        }
        if let Kind::Message(channel, _) = kind
            && bytes.len() > channel.limit(&peer.limits)
        {
            let why = format!("a message of {} bytes is over the limit", bytes.len());
            self.close(to, CloseCode::Limit, &why, air, out);
            self.end(to, Closed::Broken(why.into()), out);
            return;
        }
        let incoming = peer
            .incoming
            .entry(key)
            .or_insert_with(|| Incoming { has: vec![false; pieces], missing: pieces });
        if !std::mem::replace(&mut incoming.has[index], true) {
            incoming.missing -= 1;
        }
        if incoming.missing > 0 {
            return;
        }
        peer.set_done(key);
        match kind {
            Kind::Handshake(step) => self.shake_hands(to, step, air, out),
            Kind::Message(channel, order) => {
                self.open(to, out);
                self.deliver(to, channel, order, bytes.to_vec(), out);
                self.pump(to, air, out);
            }
        }
    }

    /// A message is complete.
    fn deliver(
        &mut self,
        to: Side,
        channel: Channel,
        order: u64,
        bytes: Vec<u8>,
        out: &mut Outcome,
    ) {
        let Some(peer) = self.peer(to) else { return };
        peer.stats.received_bytes += bytes.len() as u64;
        if channel == Channel::Control {
            peer.early_control.insert(order, bytes);
            while let Some(bytes) = peer.early_control.remove(&peer.next_control) {
                peer.next_control += 1;
                peer.events.push_back(LinkEvent::Received(channel, bytes));
            }
        } else {
            peer.events.push_back(LinkEvent::Received(channel, bytes));
        }
        out.wakes.extend(peer.wake.clone());
    }

    fn shake_hands(&mut self, at: Side, step: u8, air: &mut Air, out: &mut Outcome) {
        match step {
            // The server's end is there, and the client asks for a session.
            0 | 1 => {}
            2 => {
                self.open(Side::Server, out);
                out.accepted = true;
            }
            _ => {
                self.open(Side::Client, out);
                self.pump(at, air, out);
                return;
            }
        }
        if let Some(peer) = self.peer(at) {
            peer.push(None, Kind::Handshake(step + 1), Arc::from([0_u8; 64]));
        }
        self.pump(at, air, out);
    }

    pub(super) fn open(&mut self, side: Side, out: &mut Outcome) {
        if let Some(peer) = self.peer(side)
            && peer.phase == Phase::Opening
        {
            peer.phase = Phase::Open;
            peer.events.push_back(LinkEvent::Opened);
            out.wakes.extend(peer.wake.clone());
        }
    }

    /// Time has passed.
    pub(super) fn time(&mut self, side: Side, air: &mut Air, out: &mut Outcome) {
        let now = air.now;
        let Some(peer) = self.peer(side) else { return };
        match &peer.phase {
            Phase::Over => return,
            Phase::Closing { until, .. } => {
                if *until <= now {
                    peer.end();
                }
                return;
            }
            Phase::Opening if peer.last_heard + super::IDLE <= now => {
                self.end(side, Closed::Lost("there is no answer".into()), out);
                return;
            }
            Phase::Open if peer.last_heard + super::IDLE <= now => {
                let why = format!("nothing was heard for {} s", super::IDLE.as_secs());
                self.end(side, Closed::Lost(why.into()), out);
                return;
            }
            Phase::Opening | Phase::Open => {}
        }
        if peer.loss_deadline().is_some_and(|deadline| deadline <= now) {
            self.detect_losses(side, air);
            self.pump(side, air, out);
        }
        let Some(peer) = self.peer(side) else { return };
        if peer.probe_deadline().is_some_and(|deadline| deadline <= now) {
            peer.timeouts += 1;
            peer.last_sent = now;
            let given_up = peer.forget_useless_flights();
            // Whatever the window says: the two oldest pieces once more.
            let oldest: Vec<_> =
                peer.in_flight.values().take(2).map(|f| (f.key, f.index)).collect();
            for (key, piece) in oldest {
                self.transmit(side, key, piece, air);
            }
            self.give_up(side, &given_up);
            self.pump(side, air, out);
        }
    }

    /// A link says goodbye: what is queued on the control channel leaves first, once.
    pub(super) fn close(
        &mut self,
        side: Side,
        code: CloseCode,
        why: &str,
        air: &mut Air,
        out: &mut Outcome,
    ) {
        let id = self.id;
        loop {
            let Some(peer) = self.peer(side) else { return };
            let (Phase::Open, Some(&key)) = (&peer.phase, peer.queues[1].front()) else { break };
            let Some(piece) = peer.outgoing.get(&key).map(|message| message.left) else { break };
            self.leave(side, 1, key, air, out);
            self.transmit(side, key, piece, air);
        }
        let Some(peer) = self.peer(side) else { return };
        if !matches!(peer.phase, Phase::Opening | Phase::Open) {
            return;
        }
        let (until, why) = (air.now + peer.probe_delay() * 3, Arc::<str>::from(why));
        let leaves = peer.line_free;
        peer.end();
        peer.phase = Phase::Closing { code, why: why.clone(), until };
        air.send(id, side.other(), leaves, Datagram::Close { code, why });
    }

    /// An end is over, and says so to its owner.
    fn end(&mut self, side: Side, closed: Closed, out: &mut Outcome) {
        if let Some(peer) = self.peer(side) {
            if !matches!(peer.phase, Phase::Closing { .. }) {
                peer.end();
            }
            peer.events.push_back(LinkEvent::Closed(closed));
            out.wakes.extend(peer.wake.clone());
        }
    }
}

/// Whether a piece of a message fits into the window; what is gone always does.
fn fits(peer: &Peer, key: u64, piece: usize, window: usize) -> bool {
    let bytes = peer.outgoing.get(&key).map_or(0, |message| message.piece_bytes(piece));
    peer.in_flight_bytes == 0 || peer.in_flight_bytes + bytes <= window
}
