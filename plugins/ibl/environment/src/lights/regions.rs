//! The map, cut into regions of equal worth.
//!
//! Recursive cuts along the azimuth or the height, as median-cut sampling (P. Debevec, *A Median Cut
//! Algorithm for Light Probe Sampling*, SIGGRAPH 2005 posters), but at fractions of a texel, so that each
//! region has its exact share, for any number of regions; and along the side that leaves both parts
//! the more compact, measured by the length of the sum of their energy's vectors.

use glam::DVec3;
use rayon::prelude::*;

use super::{
    EnvironmentLight, order,
    sums::{Rect, Sums},
};
use crate::random::Random;

/// Regions of equal luminous energy, a light at a random point of each.
pub(super) fn random(sums: &Sums, count: usize, random: &mut Random) -> Vec<EnvironmentLight> {
    let regions = regions(sums, count, random);
    let points = mirrored(count, random);
    let lights: Vec<_> = (regions.par_iter().zip(points))
        .map(|(region, u)| light(sums.sample(*region, u), sums.sent(*region).energy))
        .collect();
    order::spread(&lights, random)
}

/// Regions of equal worth, a light in the middle of each one's energy.
///
/// The irradiance of a normal n under a region that lies wholly above n's horizon is n V, where V is
/// the sum of the region's energy times its unit vectors; so the light stands along V. It carries all
/// the energy, a little more than |V|: that makes good on average what is missed where a horizon crosses
/// a region. (The mean of the irradiance over all normals is a quarter of the energy, under the
/// map as under the lights.)
pub(super) fn centred(sums: &Sums, count: usize, random: &mut Random) -> Vec<EnvironmentLight> {
    let regions = regions(sums, count, random);
    let lights: Vec<_> = (regions.par_iter())
        .map(|region| {
            let sent = sums.sent(*region);
            let middle = sent.vector.try_normalize();
            light(middle.unwrap_or_else(|| sums.sample(*region, [0.5; 2])), sent.energy)
        })
        .collect();
    order::spread(&lights, random)
}

fn light(direction: DVec3, irradiance: DVec3) -> EnvironmentLight {
    EnvironmentLight {
        direction: direction.normalize().as_vec3(),
        irradiance: irradiance.as_vec3(),
    }
}

/// Points of the unit square, each even over it, four after each other balanced about the middle:
/// what neighbouring regions make too bright on one side they make too dark on the other.
fn mirrored(count: usize, random: &mut Random) -> Vec<[f64; 2]> {
    let fours = (0..count.div_ceil(4)).flat_map(|_| {
        let [x, y] = [random.unit(), random.unit()];
        [[x, y], [1.0 - x, 1.0 - y], [1.0 - x, y], [x, 1.0 - y]]
    });
    fours.take(count).collect()
}

/// The map in `count` parts of equal worth; neighbours in the list are neighbours on the sky.
fn regions(sums: &Sums, count: usize, random: &mut Random) -> Vec<Rect> {
    let mut regions = Vec::with_capacity(count);
    let whole = sums.whole(random.unit() * sums.width as f64);
    cut(sums, whole, count, random, &mut regions);
    regions
}

fn cut(sums: &Sums, rect: Rect, count: usize, random: &mut Random, regions: &mut Vec<Rect>) {
    if count == 1 {
        regions.push(rect);
        return;
    }
    let first = (count + usize::from(random.unit() < 0.5)) / 2;
    let u = first as f64 / count as f64;
    let x = sums.column_at(rect, u);
    let y = sums.row_at(rect, u);
    let [left, right] = [[rect.x[0], x], [x, rect.x[1]]].map(|x| Rect { x, ..rect });
    let [above, below] = [[rect.y[0], y], [y, rect.y[1]]].map(|y| Rect { y, ..rect });
    let length = |rect: Rect| sums.of(rect).truncate().length();
    let [one, other] = if length(left) + length(right) > length(above) + length(below) {
        [left, right]
    } else {
        [above, below]
    };
    cut(sums, one, first, random, regions);
    cut(sums, other, count - first, random, regions);
}
