//! A network in memory and in virtual time: links with delay, jitter, loss, reordering, a bounded
//! rate and outages, the same every time under a seed.
//!
//! It stands for QUIC (RFC 9000, RFC 9002): messages go in packets of [`PACKET`] bytes; packets are
//! acknowledged; one that is missing when later ones are there is sent again after 9/8 round trips
//! (or when three later ones arrived), and while nothing is acknowledged a probe follows after a
//! timeout that doubles each time, until something new gets through. [`Channel::Control`] is in
//! order, the other channels deliver each message as soon as it is complete. A link that hears nothing for
//! [`IDLE`] is lost. Instead of congestion control each direction has a fixed window: it stands
//! for a controller that does not take random loss for congestion.
//!
//! [`Channel::Control`]: crate::Channel::Control
//!
//! ```
//! use std::{sync::Arc, time::Duration};
//! use farlight_wire::{Channel, Connector, LinkEvent, Limits, Listener, Transmit, TransmitId};
//! use farlight_wire::simulated::{LinkConditions, Network};
//!
//! let ms = Duration::from_millis;
//! let network = Network::new(1);
//! network.set_conditions(LinkConditions { delay: ms(50), loss: 0.05, ..Default::default() });
//! let mut listener = network.listener(&Limits::default());
//! let mut client = network.connector().connect(&Limits::default(), Arc::new(|| {}));
//! let message = b"hello".to_vec();
//! client.send(Transmit { id: TransmitId(1), channel: Channel::Control, message });
//! network.advance(ms(10_000));
//! let (mut server, _address) = listener.accept().unwrap();
//! assert_eq!(server.poll(), Some(LinkEvent::Opened));
//! assert_eq!(server.poll(), Some(LinkEvent::Received(Channel::Control, b"hello".to_vec())));
//! ```

mod air;
mod connection;
mod link;
mod network;
mod peer;
mod recovery;
#[cfg(test)]
mod tests;

use std::time::Duration;

pub use link::{SimulatedConnector, SimulatedLink, SimulatedListener};
pub use network::Network;

use crate::Channel;

/// Bytes of messages in a packet.
pub const PACKET: usize = 1200;

/// Bytes that a packet has beyond those of messages, roughly: IP, UDP, QUIC, authentication tag.
pub const OVERHEAD: usize = 60;

/// A link that hears nothing for so long is lost.
pub const IDLE: Duration = Duration::from_secs(10);

/// How a network behaves, in both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkConditions {
    /// From one end to the other; half a round trip.
    pub delay: Duration,
    /// Up to so much more, at random for each packet.
    pub jitter: Duration,
    /// The probability that a packet is lost, 0 to 1.
    pub loss: f32,
    /// The probability that a packet takes another half `delay` longer than those around it, 0 to 1.
    pub reorder: f32,
    /// Bytes a second of each direction of a link; `None` is without a bound.
    pub bandwidth: Option<u64>,
    /// Bytes that may be under way without having been acknowledged, in each direction of a link.
    pub window: usize,
}

impl Default for LinkConditions {
    /// A quick, faultless line.
    fn default() -> Self {
        Self {
            delay: Duration::from_micros(100),
            jitter: Duration::ZERO,
            loss: 0.0,
            reorder: 0.0,
            bandwidth: None,
            window: 256 << 10,
        }
    }
}

/// What has gone one way on a channel, over all links of a network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Messages that left (each counted once).
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
}

/// What a network has carried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// From clients to servers, a channel.
    up: [Traffic; 3],
    /// From servers to clients.
    down: [Traffic; 3],
    /// Packets that were sent, with acknowledgements.
    pub packets: u64,
    /// Those that were lost.
    pub lost_packets: u64,
    /// Connections that were begun.
    pub connections: u64,
}

impl Counters {
    /// From clients to servers.
    #[must_use]
    pub fn to_server(&self, channel: Channel) -> Traffic {
        self.up[index(channel)]
    }

    /// From servers to clients.
    #[must_use]
    pub fn to_client(&self, channel: Channel) -> Traffic {
        self.down[index(channel)]
    }
}

fn index(channel: Channel) -> usize {
    usize::from(channel.tag()) - 1
}
