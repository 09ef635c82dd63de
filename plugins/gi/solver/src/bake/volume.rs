//! Probes on a grid.

use super::Gatherer;
use crate::{
    World,
    estimate::{GatherSettings, Progress},
    lightmap::GridState,
    probe::gather_probes,
    scene::DirectSky,
    session::{GridId, ProbeGrid},
    sh::ShRgb,
};

/// Radiance at the probes of a grid in spherical harmonics, x fastest, then y, then z: from surfaces,
/// and straight from the sky unless the gatherer's settings leave it out. What punctual lights send
/// straight is not part of it. `paths` rays a probe. `None` if `progress` stopped the work.
#[must_use]
pub fn volume(
    world: &World,
    gatherer: &Gatherer<'_>,
    grid: &ProbeGrid,
    paths: u32,
    progress: Progress<'_>,
) -> Option<Vec<ShRgb>> {
    let positions = GridState::new(GridId(0), *grid).positions();
    let settings = GatherSettings { paths, seed: gatherer.settings().seed };
    let light = gather_probes(world, &positions, &settings, progress)?;
    let sky = gatherer.settings().direct_sky == DirectSky::Included;
    Some(light.iter().map(|l| if sky { l.indirect + l.sky } else { l.indirect }).collect())
}
