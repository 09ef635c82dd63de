//! Probe volumes.

use bevy::prelude::*;
use farlight_gi_solver::session::{ProbeGrid, SessionChange};

use super::{ExtractedScene, Extractor, grid_id};
use crate::{
    GiProbeVolume,
    status::{GiMeter, Remarks, Stage},
};

/// Notes volumes that are new, moved, resized or gone.
pub(crate) fn extract_volumes(
    mut extractor: ResMut<Extractor>,
    extracted: Res<ExtractedScene>,
    mut remarks: ResMut<Remarks>,
    changed: Query<
        (Entity, &GiProbeVolume, &GlobalTransform),
        Or<(Changed<GiProbeVolume>, Changed<GlobalTransform>)>,
    >,
    mut removed: RemovedComponents<GiProbeVolume>,
    volumes: Query<(), With<GiProbeVolume>>,
    meter: Res<GiMeter>,
) {
    let _measure = meter.measure(Stage::Extract as usize);
    let extractor = &mut *extractor;
    for (entity, volume, transform) in &changed {
        let (id, transform) = (grid_id(entity), transform.affine());
        let problem = volume.problem().or_else(|| {
            let usable = transform.is_finite() && transform.matrix3.determinant() != 0.0;
            (!usable).then(|| "the volume's transform isn't finite, or flattens it".into())
        });
        if let Some(problem) = problem {
            remarks.note(entity, problem);
            if extracted.grids.contains_key(&id) {
                extractor.changes.receivers.push(SessionChange::RemoveGrid(id));
            }
            continue;
        }
        remarks.clear(entity);
        let grid = ProbeGrid { transform, resolution: volume.resolution };
        if extracted.grids.get(&id) != Some(&grid) {
            extractor.changes.receivers.push(SessionChange::SetGrid(id, grid));
        }
    }
    for entity in removed.read() {
        if !volumes.contains(entity) {
            remarks.clear(entity);
            extractor.changes.receivers.push(SessionChange::RemoveGrid(grid_id(entity)));
        }
    }
}
