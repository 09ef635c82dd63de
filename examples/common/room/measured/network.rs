//! What goes over the network, if the light comes from another machine.

use std::time::{Duration, Instant};

use farlight::prelude::*;
use serde::Serialize;

use super::live::Live;

/// Bytes and messages at one moment, since the start.
#[derive(Clone, Copy, Debug, Default)]
struct Counters {
    sent: u64,
    received: u64,
    updates: u64,
    update_bytes: u64,
}

/// What was sent and received, and in what time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Traffic {
    /// For how long it was watched.
    pub seconds: f32,
    /// Bytes of messages to the server.
    pub sent_bytes: u64,
    /// Bytes of messages from the server.
    pub received_bytes: u64,
    /// Messages of light among them.
    pub updates: u64,
    /// Bytes of those.
    pub update_bytes: u64,
}

/// Watches the link for a while.
pub struct Watch {
    start: Instant,
    before: Counters,
}

/// A scene at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Still {
    /// How long it took until the lighting said that it will not get better.
    pub converged_after_s: f32,
    /// What went over the network after that.
    pub traffic: Traffic,
}

/// What the report says about the network.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Network {
    /// The server.
    pub peer: String,
    /// Round trip time at the end.
    pub rtt_ms: Option<f32>,
    /// Connections after the first.
    pub reconnects: u64,
    /// From the start until the first light was shown: the scene, mostly.
    pub start: Traffic,
    /// While the lamp moved.
    pub moving: Traffic,
    /// Bytes of a message of light while the lamp moved.
    pub bytes_per_update: f32,
    /// Messages of light a second while the lamp moved.
    pub updates_per_s: f32,
    /// Bytes from the server a second while the lamp moved.
    pub received_bytes_per_s: f32,
    /// Bytes to the server a second while the lamp moved.
    pub sent_bytes_per_s: f32,
    /// At rest; not measured in a short run, or if the light did not converge in time.
    pub still: Option<Still>,
}

fn counters(live: &mut Live) -> Option<Counters> {
    let status = live.status_mut();
    let link = status.link.as_ref()?;
    Some(Counters {
        sent: link.sent_bytes,
        received: link.received_bytes,
        updates: link.updates,
        update_bytes: link.update_bytes,
    })
}

impl Watch {
    /// Begins now.
    pub fn start(live: &mut Live) -> Self {
        Self { start: Instant::now(), before: counters(live).unwrap_or_default() }
    }

    /// Whether a message of light has come since then; always where there is no link.
    pub fn has_light(&self, live: &mut Live) -> bool {
        counters(live).is_none_or(|now| now.updates > self.before.updates)
    }

    /// What went over the link since then, added to `traffic`.
    pub fn end(self, live: &mut Live, traffic: &mut Traffic) {
        let Some(now) = counters(live) else { return };
        traffic.seconds += self.start.elapsed().as_secs_f32();
        traffic.sent_bytes += now.sent.saturating_sub(self.before.sent);
        traffic.received_bytes += now.received.saturating_sub(self.before.received);
        traffic.updates += now.updates.saturating_sub(self.before.updates);
        traffic.update_bytes += now.update_bytes.saturating_sub(self.before.update_bytes);
    }
}

/// Waits until the light of a scene that stands still has converged, then watches the link. `None`
/// without a link, or if `patience` ran out.
pub fn watch_still(
    live: &mut Live,
    patience: Duration,
    watch: Duration,
) -> Result<Option<Still>, String> {
    if counters(live).is_none() {
        return Ok(None);
    }
    eprintln!("at rest, until the light has converged");
    let start = Instant::now();
    while live.status_mut().state != GiState::Converged {
        live.frame()?;
        if start.elapsed() > patience {
            return Ok(None);
        }
    }
    let converged_after_s = start.elapsed().as_secs_f32();
    // What says that it has converged may still be acknowledged.
    live.run(Duration::from_secs(1))?;
    let mut traffic = Traffic::default();
    let watching = Watch::start(live);
    live.run(watch)?;
    watching.end(live, &mut traffic);
    Ok(Some(Still { converged_after_s, traffic }))
}

impl Network {
    /// Its rows of the table.
    pub fn rows(&self, row: &mut impl FnMut(&str, String)) {
        let kb = |bytes: f32| format!("{:.1} kB", bytes * 1e-3);
        let rtt = self.rtt_ms.map_or("unknown".into(), |ms| format!("{ms:.2} ms"));
        row("server", format!("{}, round trip {rtt}", self.peer));
        row("connections that were lost", self.reconnects.to_string());
        row(
            "until the first light, sent / received",
            format!(
                "{} / {}",
                kb(self.start.sent_bytes as f32),
                kb(self.start.received_bytes as f32)
            ),
        );
        row(
            "while the lamp moves, messages of light",
            format!("{:.1} a second, {} each", self.updates_per_s, kb(self.bytes_per_update)),
        );
        row(
            "while the lamp moves, received / sent",
            format!("{} / {} a second", kb(self.received_bytes_per_s), kb(self.sent_bytes_per_s)),
        );
        match self.still {
            Some(Still { converged_after_s, traffic }) => {
                row("at rest, until converged", format!("{converged_after_s:.1} s"));
                row(
                    "  after that, in the seconds watched",
                    format!(
                        "{:.0} s: {} messages of light, {} B received, {} B sent",
                        traffic.seconds,
                        traffic.updates,
                        traffic.received_bytes,
                        traffic.sent_bytes
                    ),
                );
            }
            None => row("at rest", "not measured".into()),
        }
    }

    /// Puts it together; `None` without a link.
    pub fn new(
        live: &mut Live,
        start: Traffic,
        moving: Traffic,
        still: Option<Still>,
    ) -> Option<Self> {
        let link = live.status_mut().link.clone()?;
        let per = |bytes: u64, what: f32| if what > 0.0 { bytes as f32 / what } else { 0.0 };
        Some(Self {
            peer: link.peer.to_string(),
            rtt_ms: link.rtt.map(|rtt| rtt.as_secs_f32() * 1e3),
            reconnects: link.reconnects,
            start,
            moving,
            bytes_per_update: per(moving.update_bytes, moving.updates as f32),
            updates_per_s: per(moving.updates, moving.seconds),
            received_bytes_per_s: per(moving.received_bytes, moving.seconds),
            sent_bytes_per_s: per(moving.sent_bytes, moving.seconds),
            still,
        })
    }
}
