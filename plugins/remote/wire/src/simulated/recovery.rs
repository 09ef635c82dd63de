//! Which packets arrived, which are lost and go again (RFC 9002, 5 and 6).

use std::time::Duration;

use super::{
    air::{Air, Side},
    connection::Connection,
};

/// Packets after which a missing one is lost (RFC 9002, 6.1.1).
const PACKET_THRESHOLD: u64 = 3;

impl Connection {
    /// The other end has all packets that arrived until `at`.
    pub(super) fn acknowledge(&mut self, side: Side, at: Duration, air: &Air) {
        let Some(peer) = self.peer(side) else { return };
        let acked: Vec<u64> = peer
            .in_flight
            .iter()
            .filter(|(_, flight)| flight.received.is_some_and(|received| received <= at))
            .map(|(number, _)| *number)
            .collect();
        let Some(&largest) = acked.last() else { return };
        let mut given_up = Vec::new();
        for number in acked {
            let Some(flight) = peer.in_flight.remove(&number) else { continue };
            peer.in_flight_bytes -= flight.bytes;
            if number == largest && Some(number) > peer.largest_acked {
                peer.note_rtt(air.now.saturating_sub(flight.sent));
            }
            if let Some(message) = peer.outgoing.get_mut(&flight.key)
                && !std::mem::replace(&mut message.arrived[flight.index], true)
            {
                message.missing -= 1;
                if message.missing == 0 {
                    peer.outgoing.remove(&flight.key);
                }
            }
            given_up.extend(peer.is_given_up(flight.key).then_some(flight.key));
        }
        peer.largest_acked = peer.largest_acked.max(Some(largest));
        peer.timeouts = 0;
        self.give_up(side, &given_up);
    }

    /// The other end need not wait for messages that will not be completed.
    pub(super) fn give_up(&mut self, side: Side, keys: &[u64]) {
        if let Some(receiver) = self.peer(side.other()) {
            keys.iter().for_each(|key| receiver.set_done(*key));
        }
    }

    /// Packets before acknowledged ones that are late are lost.
    pub(super) fn detect_losses(&mut self, side: Side, air: &Air) {
        let Some(peer) = self.peer(side) else { return };
        let Some(largest) = peer.largest_acked else { return };
        let late = air.now.saturating_sub(peer.loss_delay());
        let lost: Vec<u64> = peer
            .in_flight
            .range(..largest)
            .filter(|(number, flight)| {
                largest - **number >= PACKET_THRESHOLD || flight.sent <= late
            })
            .map(|(number, _)| *number)
            .collect();
        let mut given_up = Vec::new();
        for number in lost {
            let Some(flight) = peer.in_flight.remove(&number) else { continue };
            peer.in_flight_bytes -= flight.bytes;
            match peer.outgoing.get(&flight.key) {
                Some(message) if !message.cancelled => {
                    peer.again.push_back((flight.key, flight.index));
                }
                _ => {}
            }
            given_up.extend(peer.is_given_up(flight.key).then_some(flight.key));
        }
        self.give_up(side, &given_up);
    }
}
