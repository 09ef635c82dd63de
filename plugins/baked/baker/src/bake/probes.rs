//! Where probes go.

use farlight_gi_solver::{bake::Layout, session::ProbeGrid};
use glam::{UVec3, Vec3};

use super::geometry::{bounds, unit_cube_to};
use crate::{BakeOptions, Probes};

/// Most probes of a standard bake.
const MOST: u32 = 2000;
/// Smallest distance of probes in metres of a standard bake.
const NEAREST: f32 = 0.5;
/// Most probes along an axis: the textures stay small enough for every graphics card.
const ALONG: u32 = 64;
/// Least height of the box in metres.
const HEIGHT: f32 = 2.0;
/// By how much of its edges the box is smaller than the receivers' on each side: outer walls have a
/// thickness, and nobody stands in them.
const SHRINK: f32 = 0.01;

/// Boxes of probes for a layout.
pub(super) fn grids(options: &BakeOptions, layout: &Layout) -> Vec<ProbeGrid> {
    let [low, mut high] = bounds(layout);
    if !(high - low).is_finite() {
        return Vec::new();
    }
    // A floor alone has air above it, where things stand and move.
    high.y = high.y.max(low.y + HEIGHT);
    let (center, size) = ((low + high) * 0.5, (high - low).max(Vec3::splat(1e-3)));
    let resolution = match options.probes {
        Probes::None => return Vec::new(),
        Probes::Spacing(metres) => cells(size, metres),
        Probes::Standard => {
            let mut metres = NEAREST;
            while cells(size, metres).element_product() > MOST {
                metres *= 1.05;
            }
            cells(size, metres)
        }
    };
    let half = size * (0.5 - SHRINK);
    vec![ProbeGrid { transform: unit_cube_to(center - half, center + half), resolution }]
}

/// Probes along the edges of a box. Two at least: with one there is no gradient.
fn cells(size: Vec3, metres: f32) -> UVec3 {
    (size / metres).round().as_uvec3().clamp(UVec3::splat(2), UVec3::splat(ALONG))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hall_has_no_more_probes_than_a_room() {
        assert_eq!(cells(Vec3::new(4.0, 2.5, 3.0), 0.5), UVec3::new(8, 5, 6));
        assert_eq!(cells(Vec3::new(1000.0, 0.1, 3.0), 0.5), UVec3::new(64, 2, 6));
    }
}
