//! How a backend on another machine is connected, for games to show.

use std::{sync::Arc, time::Duration};

/// The connection of a backend to another machine. Counters grow from the start of the backend, over
/// all connections.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinkStatus {
    /// Whom it connects to.
    pub peer: Arc<str>,
    /// Whether it is connected.
    pub state: LinkState,
    /// Round trip time, once it is known.
    pub rtt: Option<Duration>,
    /// Bytes of messages sent, without what the network adds.
    pub sent_bytes: u64,
    /// Bytes of messages received, likewise.
    pub received_bytes: u64,
    /// Messages of light received.
    pub updates: u64,
    /// Bytes of those.
    pub update_bytes: u64,
    /// Connections that were made after the first one was lost.
    pub reconnects: u64,
    /// Snapshots that were submitted and that the other machine has not confirmed.
    pub snapshot_lag: u64,
    /// Bytes of meshes and images that were asked for and have not left.
    pub unsent_blob_bytes: u64,
}

/// Whether there is a connection.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum LinkState {
    /// The first one is being made.
    #[default]
    Connecting,
    /// There is one.
    Connected,
    /// It was lost or doesn't answer, and a new one is being made.
    Reconnecting {
        /// Attempts so far, from 1.
        attempt: u32,
        /// Why.
        why: Arc<str>,
        /// Until the next attempt; zero while one is under way.
        retry_in: Duration,
    },
    /// There is none, and none will be made: trying again would not help. The backend's state says
    /// why.
    GivenUp,
}

impl LinkStatus {
    /// Mean bytes of a message of light, if there was one.
    #[must_use]
    pub fn bytes_per_update(&self) -> Option<f64> {
        (self.updates > 0).then(|| self.update_bytes as f64 / self.updates as f64)
    }
}
