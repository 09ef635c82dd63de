//! What can be told about the sessions of a server.

use std::time::Duration;

use farlight_gi_solver::session::SnapshotId;
use farlight_wire::SceneSize;

use crate::{bell::lock, house::Room};

/// A session as it is now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionReport {
    /// Counts the sessions of a server from 1.
    pub number: u64,
    /// What its client calls itself.
    pub name: String,
    /// Its client's address; `None` while it is away.
    pub address: Option<String>,
    /// How long its client has been away.
    pub away: Option<Duration>,
    /// How large its scene is.
    pub size: SceneSize,
    /// The newest snapshot that was answered.
    pub snapshot: SnapshotId,
    /// Updates of light so far.
    pub updates: u64,
    /// Whether nothing better will come until the scene changes.
    pub converged: bool,
}

impl SessionReport {
    pub(crate) fn new(room: &Room, now: Duration) -> Self {
        let progress = lock(&room.progress);
        Self {
            number: room.number,
            name: room.name.clone(),
            address: progress.address.clone(),
            away: progress.away_since.map(|since| now.saturating_sub(since)),
            size: progress.size,
            snapshot: progress.snapshot,
            updates: progress.updates,
            converged: progress.converged,
        }
    }
}
