//! The network backend as a game has it, without the game: what was submitted, and what it shows.

use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

use farlight::{
    gi::{
        BackendState, GiUpdate, LightingBackend,
        solver::{
            atlas::TexelRect,
            scene::InstanceId,
            session::{Session, SessionChange, SnapshotId},
        },
    },
    remote::{RemoteBackend, RemoteSettings},
};

use crate::room::{self, room};

/// Only a guard against hanging.
const PATIENCE: Duration = Duration::from_secs(60);

/// A lightmap page as the textures of a game hold it.
pub struct Shown {
    edge: usize,
    /// Red of every texel, E / π.
    texels: Vec<f32>,
    places: BTreeMap<InstanceId, TexelRect>,
    snapshot: SnapshotId,
}

impl Shown {
    fn new() -> Self {
        let edge = room::settings().page_size as usize;
        let (texels, places) = (vec![0.0; edge * edge], BTreeMap::new());
        Self { edge, texels, places, snapshot: SnapshotId(0) }
    }

    fn take(&mut self, update: &GiUpdate) {
        self.snapshot = self.snapshot.max(update.snapshot);
        self.places.extend(update.placements.iter().map(|p| (p.instance, p.rect)));
        for tile in &update.tiles {
            let width = tile.rect.width as usize;
            for (row, texels) in tile.texels.chunks_exact(8 * width).enumerate() {
                let start = (tile.rect.y as usize + row) * self.edge + tile.rect.x as usize;
                let red = texels.chunks_exact(8).map(|t| half(u16::from_le_bytes([t[0], t[1]])));
                self.texels[start..].iter_mut().zip(red).for_each(|(to, from)| *to = from);
            }
        }
    }

    /// Mean over the rectangles of all receivers; `None` before all six walls have theirs.
    fn mean(&self) -> Option<f32> {
        let mut sum = (0.0, 0.0);
        for rect in self.places.values() {
            for y in rect.y..rect.y + rect.height {
                let start = y as usize * self.edge + rect.x as usize;
                let row = &self.texels[start..start + rect.width as usize];
                sum = (sum.0 + row.iter().sum::<f32>(), sum.1 + row.len() as f32);
            }
        }
        (self.places.len() == room::WALLS).then_some(sum.0 / sum.1)
    }
}

/// What a lamp of 1 cd does in the room, solved in this process until converged.
pub fn mean_of_one_candela() -> f32 {
    let mut session = Session::new(room::settings().session());
    session.apply(SnapshotId(1), room(1.0));
    let mut shown = Shown::new();
    while !session.is_idle() {
        if let Some(update) = session.step() {
            shown.take(&GiUpdate::encode(&update));
        }
    }
    shown.mean().unwrap()
}

/// A game that asks a server for light.
pub struct Game {
    backend: Box<dyn LightingBackend>,
    submitted: SnapshotId,
    shown: Shown,
}

impl Game {
    /// Joins the server that an invitation names.
    pub fn join(invitation: &str) -> Self {
        let settings = RemoteSettings::from_invitation(invitation).unwrap();
        let factory = RemoteBackend::factory(settings);
        Self { backend: factory(&room::settings()), submitted: SnapshotId(0), shown: Shown::new() }
    }

    /// Changes the scene.
    pub fn submit(&mut self, changes: Vec<SessionChange>) {
        self.submitted.0 += 1;
        self.backend.submit(self.submitted, changes);
    }

    /// How the backend is doing.
    pub fn state(&self) -> BackendState {
        self.backend.state()
    }

    /// Connections after the first.
    pub fn reconnects(&self) -> u64 {
        self.backend.link().map_or(0, |link| link.reconnects)
    }

    /// Goes on until the newest snapshot is shown and the mean of the light is as expected, within
    /// 3 %.
    pub fn wait_for_light(&mut self, expected: f32, what: &str) {
        let start = Instant::now();
        loop {
            while let Some(update) = self.backend.poll() {
                self.shown.take(&update);
            }
            let mean = self.shown.mean();
            let right = mean.is_some_and(|mean| (mean / expected - 1.0).abs() < 0.03);
            if right && self.shown.snapshot == self.submitted {
                return;
            }
            assert!(
                start.elapsed() < PATIENCE && !matches!(self.state(), BackendState::Failed(_)),
                "{what}: mean {mean:?}, not {expected}; {:?} of {:?}; {:?}; {:?}",
                self.shown.snapshot,
                self.submitted,
                self.state(),
                self.backend.link(),
            );
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Goes on until the backend gives up; why it does.
    pub fn wait_for_failure(&mut self) -> String {
        let start = Instant::now();
        loop {
            if let BackendState::Failed(reason) = self.state() {
                return reason.to_string();
            }
            assert!(start.elapsed() < PATIENCE, "it does not give up: {:?}", self.state());
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// IEEE 754 binary16, finite and not negative.
fn half(bits: u16) -> f32 {
    let (exponent, mantissa) = (i32::from(bits >> 10), f32::from(bits & 0x3ff));
    match exponent {
        0 => mantissa * 2.0_f32.powi(-24),
        _ => (1024.0 + mantissa) * 2.0_f32.powi(exponent - 25),
    }
}
