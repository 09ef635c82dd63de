//! A backend that solves nothing: it remembers what it was told and answers what a test wants.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, MutexGuard},
};

use bevy::prelude::*;
use farlight::gi::{
    BackendState, GiPlugin, GiUpdate, LightingBackend, LinkStatus,
    solver::{
        SceneChange,
        atlas::{PageId, TexelRect},
        scene::InstanceId,
        session::{GridId, GridUpdate, LightingUpdate, Placement, SessionChange, SnapshotId, Tile},
        sh::ShRgb,
    },
};

/// The test's end of the backend.
#[derive(Clone, Default)]
pub(crate) struct Mock(Arc<Mutex<State>>);

#[derive(Default)]
pub(crate) struct State {
    /// All submissions so far.
    pub(crate) submitted: Vec<(SnapshotId, Vec<SessionChange>)>,
    /// What will be polled.
    pub(crate) updates: VecDeque<GiUpdate>,
    /// What the backend says of itself.
    pub(crate) state: BackendState,
    /// Whether to claim once that the scene is lost.
    pub(crate) lost: bool,
    /// What it says of its connection.
    pub(crate) link: Option<LinkStatus>,
    /// How many backends were made.
    pub(crate) made: usize,
    /// How often all light was asked for again.
    pub(crate) resyncs: usize,
}

struct Backend(Mock);

impl Mock {
    /// The plugin with this backend.
    pub(crate) fn plugin(&self) -> GiPlugin {
        let mock = self.clone();
        GiPlugin::with_backend(move |_| {
            mock.lock().made += 1;
            Box::new(Backend(mock.clone()))
        })
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap()
    }

    /// All changes since this was last called.
    pub(crate) fn take_changes(&self) -> Vec<SessionChange> {
        self.lock().submitted.drain(..).flat_map(|(_, changes)| changes).collect()
    }

    /// Sends an update.
    pub(crate) fn send(&self, update: &LightingUpdate) {
        self.lock().updates.push_back(GiUpdate::encode(update));
    }

    /// Sends a tile that covers the whole rectangle, with a placement of `entity` there.
    pub(crate) fn place(&self, entity: Entity, rect: TexelRect, color: impl Fn(u32, u32) -> Vec3) {
        let texels = (0..rect.height)
            .flat_map(|y| (0..rect.width).map(move |x| (x, y)))
            .map(|(x, y)| color(x, y))
            .collect();
        let (page, instance) = (PageId(0), InstanceId(entity.to_bits()));
        self.send(&LightingUpdate {
            placements: vec![Placement { instance, page, rect }],
            tiles: vec![Tile { page, rect, texels }],
            ..empty()
        });
    }

    /// Sends a grid.
    pub(crate) fn light_volume(&self, entity: Entity, resolution: UVec3, probes: Vec<ShRgb>) {
        let grid = GridId(entity.to_bits());
        self.send(&LightingUpdate {
            grids: vec![GridUpdate { grid, resolution, probes }],
            ..empty()
        });
    }
}

/// An update that says nothing.
pub(crate) fn empty() -> LightingUpdate {
    LightingUpdate { snapshot: SnapshotId(1), ..default() }
}

impl LightingBackend for Backend {
    fn submit(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>) {
        self.0.lock().submitted.push((snapshot, changes));
    }

    fn poll(&mut self) -> Option<GiUpdate> {
        self.0.lock().updates.pop_front()
    }

    fn state(&self) -> BackendState {
        self.0.lock().state.clone()
    }

    fn link(&self) -> Option<LinkStatus> {
        self.0.lock().link.clone()
    }

    fn resync(&mut self) {
        self.0.lock().resyncs += 1;
    }

    fn lost_scene(&mut self) -> bool {
        std::mem::take(&mut self.0.lock().lost)
    }
}

/// Scene changes among session changes.
pub(crate) fn scene_changes(changes: &[SessionChange]) -> Vec<&SceneChange> {
    changes
        .iter()
        .filter_map(|change| match change {
            SessionChange::Scene(change) => Some(change),
            _ => None,
        })
        .collect()
}
