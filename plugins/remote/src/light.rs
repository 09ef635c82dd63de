//! From messages of light to updates of the plugin.

use std::{collections::HashMap, time::Duration};

use bevy::math::UVec3;
use farlight_gi::{
    EncodedGrid, EncodedTile, GiUpdate, UpdateTimes,
    solver::{
        session::{GridId, SessionChange},
        sh::ShRgb,
    },
};
use farlight_wire::{HalfGrid, LightingMessage, ServerTimes, Trip};

/// Probe grids as far as they have arrived: they come in runs, and are shown when they are whole.
#[derive(Debug, Default)]
pub(crate) struct Grids(HashMap<GridId, Grid>);

#[derive(Debug)]
struct Grid {
    resolution: UVec3,
    /// Empty until something arrives.
    probes: Vec<Option<ShRgb>>,
    missing: usize,
    changed: bool,
}

impl Grids {
    /// Notes which grids there are: probes of others are not kept, whatever a server sends.
    pub(crate) fn submitted(&mut self, changes: &[SessionChange]) {
        for change in changes {
            match change {
                SessionChange::SetGrid(id, grid) => {
                    let resolution = grid.resolution;
                    if self.0.get(id).is_none_or(|known| known.resolution != resolution) {
                        let new =
                            Grid { resolution, probes: Vec::new(), missing: 0, changed: false };
                        self.0.insert(*id, new);
                    }
                }
                SessionChange::RemoveGrid(id) => drop(self.0.remove(id)),
                _ => {}
            }
        }
    }

    fn receive(&mut self, run: &HalfGrid) {
        let Some(grid) = self.0.get_mut(&run.grid) else { return };
        if grid.resolution != run.resolution {
            return;
        }
        if grid.probes.is_empty() {
            let count = grid.resolution.to_array().map(|n| n as usize).iter().product();
            grid.probes = vec![None; count];
            grid.missing = count;
        }
        let places = grid.probes.iter_mut().skip(run.first as usize);
        for (place, probe) in places.zip(run.to_probes()) {
            grid.missing -= usize::from(place.is_none());
            *place = Some(probe);
            grid.changed = true;
        }
    }

    /// Whole grids that changed.
    fn take_changed(&mut self) -> Vec<EncodedGrid> {
        let changed = self.0.iter_mut().filter(|(_, grid)| grid.changed && grid.missing == 0);
        changed
            .map(|(id, grid)| {
                grid.changed = false;
                let probes: Vec<ShRgb> = grid.probes.iter().flatten().copied().collect();
                EncodedGrid::from_probes(*id, grid.resolution, &probes)
            })
            .collect()
    }

    /// Encodes a message for the textures.
    pub(crate) fn update(&mut self, message: LightingMessage, trip: Option<Trip>) -> GiUpdate {
        message.grids.iter().for_each(|run| self.receive(run));
        let tiles = message
            .tiles
            .iter()
            .map(|tile| EncodedTile::from_half_bits(tile.page, tile.rect, &tile.texels))
            .collect();
        GiUpdate {
            snapshot: message.snapshot,
            placements: message.placements,
            refused: message.refused,
            tiles,
            grids: self.take_changed(),
            quality: message.quality,
            times: times(&message.times, trip),
        }
    }
}

/// Where the time of a message went, decoding aside.
fn times(server: &ServerTimes, trip: Option<Trip>) -> UpdateTimes {
    let measured = |time: Duration| (*server != ServerTimes::default()).then_some(time);
    UpdateTimes {
        send: trip.map(|trip| trip.send),
        solve: measured(server.solve),
        encode: measured(server.encode),
        transfer: trip.map(|trip| trip.transfer),
        decode: None,
    }
}

#[cfg(test)]
mod tests {
    use farlight_gi::solver::session::ProbeGrid;

    use super::*;

    fn message(grids: Vec<HalfGrid>) -> LightingMessage {
        LightingMessage { grids, ..Default::default() }
    }

    fn run(grid: u64, resolution: UVec3, first: u32, count: usize) -> HalfGrid {
        let probes = vec![[[0x3c00; 3]; 9]; count];
        HalfGrid { grid: GridId(grid), resolution, first, probes }
    }

    #[test]
    fn grids_are_shown_when_they_are_whole_and_then_in_parts() {
        let resolution = UVec3::new(2, 3, 4);
        let mut grids = Grids::default();
        let grid = ProbeGrid { transform: Default::default(), resolution };
        grids.submitted(&[SessionChange::SetGrid(GridId(7), grid)]);
        let mut shown = |first, count| {
            let update = grids.update(message(vec![run(7, resolution, first, count)]), None);
            update.grids.len()
        };
        assert_eq!(shown(0, 20), 0);
        assert_eq!(shown(0, 20), 0);
        assert_eq!(shown(20, 4), 1);
        assert_eq!(shown(5, 1), 1, "a part of what is whole");
        assert_eq!(shown(23, 100), 1, "what does not fit is left out");
        assert_eq!(shown(u32::MAX, 1), 0);
    }

    #[test]
    fn grids_that_nobody_asked_for_are_not_kept() {
        let mut grids = Grids::default();
        let grid = ProbeGrid { transform: Default::default(), resolution: UVec3::ONE };
        grids.submitted(&[SessionChange::SetGrid(GridId(1), grid)]);
        let foreign = run(2, UVec3::splat(100), 0, 1);
        let other_size = run(1, UVec3::splat(2), 0, 8);
        let update = grids.update(message(vec![foreign, other_size]), None);
        assert!(update.grids.is_empty());
        assert!(grids.0.len() == 1 && grids.0[&GridId(1)].probes.is_empty());
        grids.submitted(&[SessionChange::RemoveGrid(GridId(1))]);
        assert!(grids.0.is_empty());
    }
}
