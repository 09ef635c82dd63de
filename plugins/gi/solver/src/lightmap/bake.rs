//! Solving a scene to the end, for files instead of frames.

use std::{collections::BTreeMap, ops::ControlFlow, sync::Arc};

use glam::Vec3;

use crate::{
    Scene,
    scene::InstanceId,
    session::{
        GridId, GridUpdate, Placement, ProbeGrid, Quality, Session, SessionChange, SessionSettings,
        SnapshotId,
    },
};

/// Solves the lightmaps and probe grids of a scene that does not change.
///
/// The same machinery as a [`Session`]'s, run until it has nothing left to do; equal inputs give equal
/// results on any number of threads.
///
/// ```
/// # use farlight_gi_solver::{Scene, lightmap::LightmapSolver, session::SessionSettings};
/// # use std::ops::ControlFlow;
/// let scene = Scene::default(); // from a file, or built by hand
/// let lightmap = LightmapSolver::new(SessionSettings { converged_paths: 1024, ..Default::default() })
///     .receivers(scene.instances.keys().copied())
///     .solve(&scene, &mut |done| {
///         println!("{:.0} %", done * 100.0);
///         ControlFlow::Continue(())
///     });
/// assert!(lightmap.is_some());
/// ```
#[derive(Clone, Debug)]
pub struct LightmapSolver {
    settings: SessionSettings,
    receivers: Vec<InstanceId>,
    grids: BTreeMap<GridId, ProbeGrid>,
}

/// A solved lightmap.
#[derive(Clone, Debug, Default)]
pub struct Lightmap {
    /// Edge of the pages in texels.
    pub page_size: u32,
    /// The pages, each `page_size * page_size` values E / π (indirect, and the sky's direct part unless
    /// the scene leaves it out: [`DirectSky`](crate::scene::DirectSky)), rows from the top, dilated;
    /// zero where no receiver is near.
    pub pages: Vec<Vec<Vec3>>,
    /// Where the receivers are.
    pub placements: Vec<Placement>,
    /// Receivers that have no lightmap, and why.
    pub refused: Vec<(InstanceId, Arc<str>)>,
    /// The probe grids.
    pub grids: Vec<GridUpdate>,
    /// How good it is.
    pub quality: Quality,
}

impl LightmapSolver {
    /// A solver without receivers. [`SessionSettings::converged_paths`] says how many rays a texel
    /// gets.
    #[must_use]
    pub fn new(settings: SessionSettings) -> Self {
        Self { settings, receivers: Vec::new(), grids: BTreeMap::new() }
    }

    /// Adds instances that get a lightmap; their meshes need a second UV set.
    #[must_use]
    pub fn receivers(mut self, receivers: impl IntoIterator<Item = InstanceId>) -> Self {
        self.receivers.extend(receivers);
        self
    }

    /// Adds a probe grid.
    #[must_use]
    pub fn grid(mut self, id: GridId, grid: ProbeGrid) -> Self {
        self.grids.insert(id, grid);
        self
    }

    /// Solves. `progress` is told the part that is done, 0..=1, every few milliseconds, and may stop
    /// the work: then there is no result.
    pub fn solve(
        &self,
        scene: &Scene,
        progress: &mut dyn FnMut(f32) -> ControlFlow<()>,
    ) -> Option<Lightmap> {
        let mut session = Session::new(self.settings.clone());
        let mut changes: Vec<SessionChange> = scene.changes().map(SessionChange::Scene).collect();
        changes.extend(self.receivers.iter().copied().map(SessionChange::AddReceiver));
        changes.extend(self.grids.iter().map(|(id, grid)| SessionChange::SetGrid(*id, *grid)));
        session.apply(SnapshotId(0), changes);

        let mut out = Lightmap { page_size: session.page_size(), ..Lightmap::default() };
        let page_area = out.page_size as usize * out.page_size as usize;
        let mut grids = BTreeMap::new();
        while !session.is_idle() {
            if progress(session.progress()).is_break() {
                return None;
            }
            let Some(update) = session.step() else { continue };
            out.placements.extend(update.placements);
            out.refused.extend(update.refused);
            out.quality = update.quality;
            grids.extend(update.grids.into_iter().map(|grid| (grid.grid, grid)));
            for tile in update.tiles {
                let page = tile.page.0 as usize;
                if out.pages.len() <= page {
                    out.pages.resize(page + 1, vec![Vec3::ZERO; page_area]);
                }
                let rows = tile.texels.chunks(tile.rect.width as usize);
                for (row, y) in rows.zip(tile.rect.y..) {
                    let start = (y * out.page_size + tile.rect.x) as usize;
                    out.pages[page][start..start + row.len()].copy_from_slice(row);
                }
            }
        }
        out.grids = grids.into_values().collect();
        Some(out)
    }
}
