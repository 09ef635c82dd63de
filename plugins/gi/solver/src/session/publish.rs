//! Decides which texels are worth sending.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec3;

use super::{GridUpdate, Placement, Tile, place::Places};
use crate::{atlas::TexelRect, lightmap::Lighting, scene::InstanceId};

/// Edge of the pieces in which rectangles are sent.
const PIECE: u32 = 32;
/// Changes below this part of a value are not sent (half floats hold 2^-11).
const RELATIVE: f32 = 0.003;
/// Nor below this part of the brightest texel.
const ABSOLUTE: f32 = 1e-4;

/// What the other side holds.
#[derive(Default)]
pub(super) struct Shown {
    texels: BTreeMap<InstanceId, Vec<Vec3>>,
    /// Placements that have not been sent.
    pub new_places: BTreeSet<InstanceId>,
}

impl Shown {
    /// Forgets receivers that have no place any more.
    pub(super) fn retain(&mut self, places: &Places) {
        self.texels.retain(|id, _| places.places.contains_key(id));
        self.new_places.retain(|id| places.places.contains_key(id));
    }

    /// The placements and pieces that differ from what is shown. They count as shown from now on.
    pub(super) fn changed(
        &mut self,
        lighting: &Lighting,
        places: &Places,
    ) -> (Vec<Placement>, Vec<Tile>) {
        let (mut placements, mut tiles) = (Vec::new(), Vec::new());
        let rectangles: Vec<Vec<Vec3>> =
            (0..lighting.patches.receivers.len()).map(|i| lighting.rectangle(i)).collect();
        let brightest =
            rectangles.iter().flatten().map(|t| t.max_element()).fold(0.0_f32, f32::max);
        for (receiver, texels) in lighting.patches.receivers.iter().zip(rectangles) {
            let id = lighting.world.instances()[receiver.instance as usize].id;
            let Some(place) = places.places.get(&id) else { continue };
            let is_new = self.new_places.remove(&id);
            if is_new {
                placements.push(Placement { instance: id, page: place.page, rect: place.rect() });
            }
            let padded = place.padded;
            let old = self.texels.entry(id).or_default();
            let all = is_new || old.len() != texels.len();
            if all {
                old.clone_from(&texels);
            }
            for y in (0..padded.height).step_by(PIECE as usize) {
                for x in (0..padded.width).step_by(PIECE as usize) {
                    let width = PIECE.min(padded.width - x);
                    let height = PIECE.min(padded.height - y);
                    let indices = (y..y + height)
                        .flat_map(|y| (x..x + width).map(move |x| (y * padded.width + x) as usize));
                    let differs = indices.clone().any(|i| {
                        let tolerance = old[i].abs() * RELATIVE + brightest * ABSOLUTE;
                        (texels[i] - old[i]).abs().cmpgt(tolerance).any()
                    });
                    if all || differs {
                        for i in indices.clone() {
                            old[i] = texels[i];
                        }
                        tiles.push(Tile {
                            page: place.page,
                            rect: TexelRect { x: padded.x + x, y: padded.y + y, width, height },
                            texels: indices.map(|i| texels[i]).collect(),
                        });
                    }
                }
            }
        }
        (placements, tiles)
    }
}

/// Grids that differ from what is shown.
pub(super) fn changed_grids(lighting: &mut Lighting) -> Vec<GridUpdate> {
    lighting
        .grids
        .iter_mut()
        .filter_map(|grid| {
            grid.publish(RELATIVE).then(|| GridUpdate {
                grid: grid.id,
                resolution: grid.grid.resolution,
                probes: grid.result.clone(),
            })
        })
        .collect()
}
