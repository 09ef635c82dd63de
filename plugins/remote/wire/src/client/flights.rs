//! When snapshots were submitted and sent, to tell where time goes.

use std::{collections::VecDeque, time::Duration};

use farlight_gi_solver::session::SnapshotId;

use super::Trip;
use crate::{ServerTimes, TransmitId};

/// Snapshots that are remembered.
const MAX: usize = 64;

/// The last snapshots that were sent.
#[derive(Debug, Default)]
pub(super) struct Flights {
    flights: VecDeque<Flight>,
    /// When the oldest change that has not been sent was submitted.
    waiting_since: Option<Duration>,
}

#[derive(Debug)]
struct Flight {
    snapshot: SnapshotId,
    submitted: Duration,
    last_part: TransmitId,
    sent: Option<Duration>,
}

impl Flights {
    pub(super) fn submitted(&mut self, now: Duration) {
        self.waiting_since.get_or_insert(now);
    }

    /// A snapshot goes out; `last_part` is its last message.
    pub(super) fn departed(&mut self, now: Duration, snapshot: SnapshotId, last_part: TransmitId) {
        let submitted = self.waiting_since.take().unwrap_or(now);
        if self.flights.len() == MAX {
            self.flights.pop_front();
        }
        self.flights.push_back(Flight { snapshot, submitted, last_part, sent: None });
    }

    pub(super) fn sent(&mut self, now: Duration, id: TransmitId) {
        if let Some(flight) = self.flights.iter_mut().rev().find(|f| f.last_part == id) {
            flight.sent = Some(now);
        }
    }

    /// The first light of a snapshot came: how long its trip took. Forgets it and older ones.
    pub(super) fn answered(
        &mut self,
        now: Duration,
        snapshot: SnapshotId,
        times: &ServerTimes,
    ) -> Option<Trip> {
        let at = self.flights.iter().position(|f| f.snapshot == snapshot)?;
        let flight = self.flights.drain(..=at).next_back()?;
        let sent = flight.sent.unwrap_or(now);
        let send = sent.saturating_sub(flight.submitted);
        Some(Trip { send, transfer: now.saturating_sub(sent).saturating_sub(times.held) })
    }

    /// A new connection: times of the old one mean nothing.
    pub(super) fn forget(&mut self) {
        self.flights.clear();
    }
}
