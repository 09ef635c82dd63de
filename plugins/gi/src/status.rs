//! How the indirect light is doing, for games to show and tests to read.

use std::{borrow::Cow, sync::Arc, time::Duration};

use bevy::{ecs::entity::EntityHashMap, platform::time::Instant, prelude::*};
use farlight_core::{
    CostMeter, LeftOut, Measured, TextureUploads, TimeStats, TimeWindow,
    field::{Label, Unit},
};
use farlight_gi_solver::session::{Quality, SnapshotId};

use crate::{LinkStatus, UpdateTimes};

/// What the plugin is doing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Default, Debug, Clone)]
pub enum GiState {
    /// Nothing is tagged, or nothing of it is loaded yet.
    #[default]
    Idle,
    /// Lighting is being solved; what is shown gets better.
    Solving,
    /// The scene is still and what is shown is as good as it gets.
    Converged,
    /// What solves lighting can't be reached; it is tried again. What was solved stays on screen.
    Disconnected {
        /// Why.
        reason: Arc<str>,
    },
    /// Lighting is no longer solved. What was solved stays on screen.
    Failed {
        /// Why.
        reason: Arc<str>,
    },
}

/// How the indirect light is doing.
#[derive(Resource, Debug, Default, Reflect)]
#[reflect(Resource, Default)]
pub struct GiStatus {
    /// What the plugin is doing.
    pub state: GiState,
    /// The newest snapshot of the scene that was handed to the backend.
    #[reflect(ignore)]
    pub submitted: SnapshotId,
    /// The newest snapshot whose lighting is in the textures.
    #[reflect(ignore)]
    pub shown: SnapshotId,
    /// Updates received from the backend since the start.
    pub updates: u64,
    /// Bytes of texels written to the GPU since the start.
    #[reflect(@Unit("B"), @Label("Uploaded"))]
    pub uploaded_bytes: u64,
    /// How good what is shown is.
    #[reflect(ignore)]
    pub quality: Quality,
    /// Meshes that are lit.
    pub receivers: usize,
    /// Meshes and images that are loaded and on their way to the backend.
    pub converting: usize,
    /// Entities that don't take part as asked, and why; in the order of their entities.
    pub left_out: Vec<LeftOut>,
    /// The connection to the machine that solves, if it is another.
    #[reflect(ignore)]
    pub link: Option<LinkStatus>,
    /// Where time goes.
    pub timings: GiTimings,
}

/// Times of the last frames and updates.
#[derive(Clone, Debug, Default, Reflect)]
#[reflect(Default, Clone)]
pub struct GiTimings {
    /// Our systems a frame that read the scene.
    pub extract: StageTimes,
    /// Our systems a frame that take updates over.
    pub apply: StageTimes,
    /// Our system a frame that writes textures.
    pub upload: StageTimes,
    /// All of our systems a frame.
    pub frame: StageTimes,
    /// From the submission of a snapshot until the network had taken it over; nothing where no
    /// network is involved.
    pub send: TimeWindow,
    /// Solving, an update.
    pub solve: TimeWindow,
    /// Encoding an update, for the network or (where none is involved) for the textures.
    pub encode: TimeWindow,
    /// On the network, there and back, a snapshot; nothing where none is involved.
    pub transfer: TimeWindow,
    /// Decoding an update that came over the network.
    pub decode: TimeWindow,
    /// From the frame that submitted a snapshot to the write of the first texels that show it.
    pub latency: TimeWindow,
}

/// Times of a stage, one entry a frame.
#[derive(Clone, Debug, Default, Reflect)]
#[reflect(Default, Clone)]
pub struct StageTimes {
    /// CPU time of the threads that ran it.
    pub cpu: TimeWindow,
    /// Wall time.
    pub wall: TimeWindow,
}

impl StageTimes {
    fn push(&mut self, measured: Measured) {
        self.cpu.push(measured.cpu);
        self.wall.push(measured.wall);
    }

    /// Order statistics of the CPU time. Sorts: call it when somebody looks, not every frame.
    #[must_use]
    pub fn cpu_stats(&self) -> TimeStats {
        self.cpu.stats()
    }

    /// Order statistics of the wall time, likewise.
    #[must_use]
    pub fn wall_stats(&self) -> TimeStats {
        self.wall.stats()
    }
}

impl GiTimings {
    pub(crate) fn push(&mut self, times: &UpdateTimes) {
        let UpdateTimes { send, solve, encode, transfer, decode } = *times;
        for (window, time) in [
            (&mut self.send, send),
            (&mut self.solve, solve),
            (&mut self.encode, encode),
            (&mut self.transfer, transfer),
            (&mut self.decode, decode),
        ] {
            if let Some(time) = time {
                window.push(time);
            }
        }
    }

    /// Forgets the past, for example when loading is over.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

/// Sent when the lighting of an update is in the textures.
#[derive(Message, Clone, Copy, Debug)]
pub struct GiUpdated {
    /// The newest snapshot that it shows.
    pub snapshot: SnapshotId,
    /// When its first texels were written.
    pub first_write: Instant,
    /// When all were.
    pub all_written: Instant,
    /// How good it is.
    pub quality: Quality,
}

/// Stages of the plugin's [`CostMeter`].
#[derive(Clone, Copy)]
pub(crate) enum Stage {
    Extract,
    Apply,
}

/// The plugin's meter.
#[derive(Resource, Clone, Deref)]
pub(crate) struct GiMeter(pub(crate) CostMeter);

impl Default for GiMeter {
    fn default() -> Self {
        Self(CostMeter::new(2))
    }
}

/// Puts the frame's times into the status.
pub(crate) fn end_frame(
    mut status: ResMut<GiStatus>,
    meter: Res<GiMeter>,
    uploads: Res<TextureUploads>,
) {
    let extract = meter.take(Stage::Extract as usize);
    let apply = meter.take(Stage::Apply as usize);
    let upload = uploads.take_cost();
    let timings = &mut status.bypass_change_detection().timings;
    timings.extract.push(extract);
    timings.apply.push(apply);
    timings.upload.push(upload);
    timings.frame.push(Measured {
        cpu: extract.cpu + apply.cpu + upload.cpu,
        wall: extract.wall + apply.wall + upload.wall,
    });
}

/// Why entities are left out, before it goes into the status; each is logged once.
#[derive(Resource, Default)]
pub(crate) struct Remarks {
    reasons: EntityHashMap<Cow<'static, str>>,
    changed: bool,
}

impl Remarks {
    /// Notes why `entity` is left out.
    pub(crate) fn note(&mut self, entity: Entity, reason: impl Into<Cow<'static, str>>) {
        let reason = reason.into();
        if self.reasons.get(&entity) != Some(&reason) {
            warn!("{entity} is left out of the indirect light: {reason}");
            self.reasons.insert(entity, reason);
            self.changed = true;
        }
    }

    /// The reason is gone.
    pub(crate) fn clear(&mut self, entity: Entity) {
        self.changed |= self.reasons.remove(&entity).is_some();
    }

    pub(crate) fn show(&mut self, status: &mut GiStatus) {
        if std::mem::take(&mut self.changed) {
            status.left_out = self
                .reasons
                .iter()
                .map(|(&entity, reason)| LeftOut { entity, reason: reason.clone() })
                .collect();
            status.left_out.sort_by_key(|left_out| left_out.entity);
        }
    }
}

/// When snapshots were submitted, for latencies; bounded.
#[derive(Default)]
pub(crate) struct SubmitTimes(std::collections::VecDeque<(SnapshotId, Instant)>);

impl SubmitTimes {
    pub(crate) fn submitted(&mut self, snapshot: SnapshotId) {
        if self.0.len() == 1024 {
            self.0.pop_front();
        }
        self.0.push_back((snapshot, Instant::now()));
    }

    /// How long ago, at `now`, the snapshot was submitted; forgets it and older ones.
    pub(crate) fn latency(&mut self, snapshot: SnapshotId, now: Instant) -> Option<Duration> {
        while let Some(&(oldest, at)) = self.0.front() {
            if oldest > snapshot {
                return None;
            }
            self.0.pop_front();
            if oldest == snapshot {
                return Some(now.saturating_duration_since(at));
            }
        }
        None
    }
}
