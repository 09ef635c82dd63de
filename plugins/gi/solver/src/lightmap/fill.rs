//! Dilation: what texels that no surface covers hold, so that bilinear lookups never mix in garbage.
//!
//! Rings grow outwards from the covered texels. A texel takes the mean of the neighbours of one chart,
//! the one that most of them belong to, and belongs to that chart then: nothing flows from one
//! chart into another. Texels that are covered but buried in other geometry are filled the same
//! way, from their own chart only.

use super::raster::{MeshTexels, NONE};

/// In which order, and from which neighbours, the texels of a padded rectangle are filled.
#[derive(Debug, Default)]
pub(crate) struct FillPlan {
    /// Columns of the padded rectangle: one more on each side than the UV square.
    pub width: u32,
    pub height: u32,
    /// Texel of the padded rectangle for each covered texel.
    pub place: Vec<u32>,
    steps: Vec<Step>,
    sources: Vec<u32>,
}

#[derive(Debug)]
struct Step {
    place: u32,
    /// End of its part of `sources`.
    end: u32,
}

impl FillPlan {
    /// The plan for covered texels of which some are not `valid`.
    pub(crate) fn new(texels: &MeshTexels, valid: &[bool]) -> Self {
        let (width, height) = (texels.width + 2, texels.height + 2);
        let place: Vec<u32> = texels
            .coords
            .iter()
            .map(|[x, y]| (u32::from(*y) + 1) * width + u32::from(*x) + 1)
            .collect();
        let mut chart = vec![NONE; (width * height) as usize];
        // Buried texels may only be filled from their own chart.
        let mut bound = vec![NONE; chart.len()];
        for (i, &at) in place.iter().enumerate() {
            if valid[i] {
                chart[at as usize] = texels.chart[i];
            } else {
                bound[at as usize] = texels.chart[i];
            }
        }
        let mut plan = Self { width, height, place, ..Self::default() };
        let neighbours = |at: u32| {
            let (x, y) = ((at % width) as i64, (at / width) as i64);
            (0..9_i64).filter(|k| *k != 4).filter_map(move |k| {
                let (nx, ny) = (x + k % 3 - 1, y + k / 3 - 1);
                (nx >= 0 && ny >= 0 && nx < i64::from(width) && ny < i64::from(height))
                    .then(|| (ny * i64::from(width) + nx) as u32)
            })
        };
        let mut open: Vec<u32> =
            (0..chart.len() as u32).filter(|&at| chart[at as usize] == NONE).collect();
        while !open.is_empty() {
            let mut ring = Vec::new();
            for &at in &open {
                let mut votes: Vec<u32> = neighbours(at)
                    .map(|n| chart[n as usize])
                    .filter(|&c| c != NONE && [c, NONE].contains(&bound[at as usize]))
                    .collect();
                votes.sort_unstable();
                let winner = votes
                    .chunk_by(|a, b| a == b)
                    .max_by_key(|same| (same.len(), std::cmp::Reverse(same[0])));
                if let Some(winner) = winner {
                    ring.push((at, winner[0]));
                }
            }
            if ring.is_empty() {
                break;
            }
            for &(at, winner) in &ring {
                plan.sources.extend(neighbours(at).filter(|&n| chart[n as usize] == winner));
                plan.steps.push(Step { place: at, end: plan.sources.len() as u32 });
            }
            for (at, winner) in ring {
                chart[at as usize] = winner;
            }
            open.retain(|&at| chart[at as usize] == NONE);
        }
        plan
    }

    /// Fills a padded rectangle whose valid texels are set.
    pub(crate) fn apply(&self, texels: &mut [glam::Vec3]) {
        let mut start = 0;
        for step in &self.steps {
            let sources = &self.sources[start..step.end as usize];
            let sum: glam::Vec3 = sources.iter().map(|&s| texels[s as usize]).sum();
            texels[step.place as usize] = sum / sources.len() as f32;
            start = step.end as usize;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;
    use crate::scene::Mesh;

    /// Two quads side by side with a gap; left is chart 0, right chart 2.
    fn two_charts() -> MeshTexels {
        let mut mesh = Mesh::default();
        for (low, high, height) in [(0.0, 0.35, 0.0), (0.65, 1.0, 1.0)] {
            let first = mesh.positions.len() as u32;
            for uv in [(low, 0.0), (high, 0.0), (high, 1.0), (low, 1.0)] {
                mesh.uv1.push(Vec2::new(uv.0, uv.1));
                mesh.positions.push(Vec3::new(uv.0, height, uv.1));
            }
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.triangles.push([first, first + 2, first + 3]);
        }
        MeshTexels::new(&mesh, 16, 16)
    }

    #[test]
    fn charts_do_not_flow_into_each_other() {
        let texels = two_charts();
        let plan = FillPlan::new(&texels, &vec![true; texels.len()]);
        let mut values = vec![Vec3::NAN; (plan.width * plan.height) as usize];
        for (i, &at) in plan.place.iter().enumerate() {
            values[at as usize] = Vec3::splat(if texels.chart[i] == 0 { 1.0 } else { 5.0 });
        }
        plan.apply(&mut values);
        for value in values {
            assert!(value == Vec3::ONE || value == Vec3::splat(5.0), "{value}");
        }
    }

    #[test]
    fn buried_texels_take_from_their_own_chart() {
        let texels = two_charts();
        // The left chart's right edge is buried: its gap neighbours belong to it nevertheless.
        let valid: Vec<bool> = texels.coords.iter().map(|c| c[0] != 4 && c[0] != 5).collect();
        let plan = FillPlan::new(&texels, &valid);
        let mut values = vec![Vec3::NAN; (plan.width * plan.height) as usize];
        for (i, &at) in plan.place.iter().enumerate() {
            if valid[i] {
                values[at as usize] = Vec3::splat(if texels.chart[i] == 0 { 1.0 } else { 5.0 });
            }
        }
        plan.apply(&mut values);
        for (i, &at) in plan.place.iter().enumerate() {
            let expected = if texels.chart[i] == 0 { 1.0 } else { 5.0 };
            assert_eq!(values[at as usize], Vec3::splat(expected));
        }
    }
}
