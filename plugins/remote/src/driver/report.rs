//! What the game and the log are told of the connection.

use std::time::Duration;

use bevy::log::{info, warn};
use farlight_gi::{BackendState, LinkState, LinkStatus};

use super::Driver;

/// Silence is worth being shown so long after other ways are tried.
pub(super) const SHOWN_AFTER: Duration = Duration::from_secs(1);
/// The first connection may take so long before it is said that it hangs.
pub(super) const FIRST: Duration = Duration::from_secs(2);

impl Driver {
    /// Says how it is going.
    pub(super) fn report(&mut self, now: Duration) {
        let sync = self.session.state();
        let line = self.line.as_ref();
        let stats = line.map(|line| line.link.stats()).unwrap_or_default();
        let silence = line.map(|line| now.saturating_sub(self.heard(line)));
        let welcomed = line.is_some_and(|line| line.welcomed);
        let gone = self.attempts.wanted_since().map(|since| now.saturating_sub(since));
        let normal = self.bearable(now) + SHOWN_AFTER;
        let connected = welcomed && silence.is_some_and(|silence| silence < normal);
        let state = if self.failed.is_some() {
            LinkState::GivenUp
        } else if connected {
            LinkState::Connected
        } else if self.welcomes == 0 && gone.is_none_or(|gone| gone < FIRST) {
            LinkState::Connecting
        } else {
            let next = self.attempts.next().unwrap_or(now);
            let waits = !self.attempts.is_trying() && line.is_none();
            LinkState::Reconnecting {
                attempt: self.attempts.count().max(1),
                why: self.why.clone(),
                retry_in: if waits { next.saturating_sub(now) } else { Duration::ZERO },
            }
        };
        if let LinkState::Reconnecting { why, .. } = &state
            && self.told != Some(false)
        {
            let stays = if self.welcomes == 0 { "" } else { "; the light stays as it is" };
            warn!("the lighting server {} can't be reached: {why}{stays}", self.peer);
            self.told = Some(false);
        } else if connected && self.told == Some(false) {
            info!("the lighting server {} is heard again", self.peer);
            self.told = Some(true);
        }
        let backend = match (&self.failed, &state) {
            (Some(why), _) => BackendState::Failed(why.clone()),
            (None, LinkState::Reconnecting { why, .. }) => {
                BackendState::Disconnected { reason: why.clone() }
            }
            (None, _) if sync.submitted.0 == 0 => BackendState::Idle,
            (None, LinkState::Connected) if self.session.is_converged() => BackendState::Converged,
            (None, _) => BackendState::Solving,
        };
        let status = LinkStatus {
            state,
            rtt: stats.rtt.or(sync.rtt).or(self.status.rtt),
            sent_bytes: self.moved.sent_bytes + stats.sent_bytes,
            received_bytes: self.moved.received_bytes + stats.received_bytes,
            reconnects: self.welcomes.saturating_sub(1),
            snapshot_lag: sync.submitted.0.saturating_sub(sync.acknowledged.0),
            unsent_blob_bytes: sync.unsent_blob_bytes,
            ..self.status.clone()
        };
        self.status = status;
        let mut mail = self.shared.lock();
        mail.state = backend;
        mail.link.clone_from(&self.status);
    }
}
