//! Stands between the plugin and its backend and remembers: the scene as it was submitted, and what
//! the lightmap's texture holds.

use std::{
    collections::{BTreeMap, VecDeque},
    sync::{Arc, Mutex, MutexGuard},
    time::Instant,
};

use bevy::math::Vec3;
use farlight::gi::{BackendState, GiUpdate, LightingBackend, LinkStatus};
use farlight_gi_solver::{
    Scene,
    scene::InstanceId,
    session::{GridId, Placement, ProbeGrid, SessionChange, SnapshotId},
};

/// The backend that the plugin sees.
pub struct Recorder {
    inner: Box<dyn LightingBackend>,
    log: Log,
}

/// What is remembered; clones share it.
#[derive(Clone, Default)]
pub struct Log(Arc<Mutex<State>>);

/// See the fields.
#[derive(Default)]
pub struct State {
    /// The scene after the last submitted change.
    pub scene: Scene,
    /// Its snapshot.
    pub submitted: SnapshotId,
    /// When the first instance was submitted.
    pub first_submit: Option<Instant>,
    /// Where instances lie in the lightmap.
    pub placements: BTreeMap<InstanceId, Placement>,
    /// Probe grids.
    pub grids: BTreeMap<GridId, ProbeGrid>,
    /// Handed to the plugin, not known to be written yet.
    polled: VecDeque<GiUpdate>,
    /// What the texture holds, page by page, rows from the top.
    pub pages: Vec<Vec<Vec3>>,
    /// Texels along the edge of a page.
    pub edge: u32,
    /// Updates that were written.
    pub written: usize,
    /// The backend's updates are kept from the plugin; `injected` goes in their place.
    pub muted: bool,
    /// An update of somebody else's making.
    pub injected: Option<GiUpdate>,
}

impl Log {
    /// Looks at what is remembered.
    pub fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Records what goes to and comes from `inner`.
    pub fn record(&self, inner: Box<dyn LightingBackend>, edge: u32) -> Recorder {
        let mut state = self.lock();
        *state = State { edge, ..State::default() };
        drop(state);
        Recorder { inner, log: self.clone() }
    }
}

impl State {
    /// The oldest update that was handed to the plugin is in the textures now.
    pub fn confirm_written(&mut self) {
        let Some(update) = self.polled.pop_front() else { return };
        self.written += 1;
        let edge = self.edge as usize;
        for tile in &update.tiles {
            let page = tile.page.0 as usize;
            if self.pages.len() <= page {
                self.pages.resize(page + 1, vec![Vec3::ZERO; edge * edge]);
            }
            let (x, y, width) =
                (tile.rect.x as usize, tile.rect.y as usize, tile.rect.width as usize);
            for (row, texels) in tile.texels.chunks_exact(width * 8).enumerate() {
                let start = (y + row) * edge + x;
                for (to, texel) in self.pages[page][start..].iter_mut().zip(texels.chunks_exact(8))
                {
                    *to = decode(texel);
                }
            }
        }
    }
}

impl LightingBackend for Recorder {
    fn submit(&mut self, snapshot: SnapshotId, changes: Vec<SessionChange>) {
        let mut state = self.log.lock();
        for change in &changes {
            match change {
                SessionChange::Scene(change) => state.scene.apply(change.clone()),
                SessionChange::SetGrid(id, grid) => drop(state.grids.insert(*id, *grid)),
                SessionChange::RemoveGrid(id) => drop(state.grids.remove(id)),
                SessionChange::RemoveReceiver(id) => drop(state.placements.remove(id)),
                SessionChange::AddReceiver(_) => {}
            }
        }
        state.submitted = snapshot;
        if !state.scene.instances.is_empty() {
            state.first_submit.get_or_insert_with(Instant::now);
        }
        drop(state);
        self.inner.submit(snapshot, changes);
    }

    fn poll(&mut self) -> Option<GiUpdate> {
        let update = self.inner.poll();
        let mut state = self.log.lock();
        let update = if state.muted { state.injected.take() } else { update }?;
        for placement in &update.placements {
            state.placements.insert(placement.instance, *placement);
        }
        state.polled.push_back(update.clone());
        Some(update)
    }

    fn state(&self) -> BackendState {
        self.inner.state()
    }

    fn lost_scene(&mut self) -> bool {
        self.inner.lost_scene()
    }

    fn resync(&mut self) {
        self.inner.resync();
    }

    fn link(&self) -> Option<LinkStatus> {
        self.inner.link()
    }
}

/// RGB of a texel of four little-endian half floats.
fn decode(texel: &[u8]) -> Vec3 {
    let channel = |i: usize| half(u16::from_le_bytes([texel[2 * i], texel[2 * i + 1]]));
    Vec3::new(channel(0), channel(1), channel(2))
}

/// IEEE 754 binary16, finite values.
fn half(bits: u16) -> f32 {
    let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f32::from(bits & 0x3ff));
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    sign * match exponent {
        0 => mantissa * 2.0_f32.powi(-24),
        _ => (1024.0 + mantissa) * 2.0_f32.powi(exponent - 25),
    }
}
