//! The piecewise constant distribution: luminance times solid angle.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use crate::{Environment, sphere};

/// A distribution over the texels, constant over the solid angle of each.
///
/// M. Pharr, W. Jakob and G. Humphreys, *Physically Based Rendering*, 4th edition, section A.5: the row
/// by the marginal, then the column by the conditional distribution. A black map has an even one.
pub(super) struct Density<'a> {
    pub(super) environment: &'a Environment,
    pub(super) width: usize,
    pub(super) height: usize,
    /// Cosines at the edges of the rows.
    pub(super) edges: Vec<f64>,
    /// Sum of the rows before each row, and of all: height + 1.
    marginal: Vec<f64>,
    /// Sum of a row's columns before each column, and of all: width + 1 a row.
    conditional: Vec<f64>,
}

/// A point of the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) direction: DVec3,
    /// The texel it lies in.
    pub(super) texel: usize,
}

impl<'a> Density<'a> {
    pub(super) fn new(environment: &'a Environment) -> Self {
        let [width, height] = [environment.width() as usize, environment.height() as usize];
        let edges = sphere::row_edges(height);
        let black = environment.texels().iter().all(|texel| *texel == Vec3::ZERO);
        let mut marginal = vec![0.0];
        let mut conditional = Vec::with_capacity(height * (width + 1));
        let mut total = 0.0;
        for (row, cos) in environment.texels().chunks_exact(width).zip(edges.windows(2)) {
            let solid_angle = (cos[0] - cos[1]) * TAU / width as f64;
            let mut sum = 0.0;
            conditional.push(0.0);
            for texel in row {
                sum += solid_angle * if black { 1.0 } else { sphere::luminance(*texel) };
                conditional.push(sum);
            }
            total += sum;
            marginal.push(total);
        }
        Self { environment, width, height, edges, marginal, conditional }
    }

    /// Integral over the sphere; above 0.
    pub(super) fn total(&self) -> f64 {
        self.marginal[self.height]
    }

    /// Draws a point for a point of the unit square.
    pub(super) fn sample(&self, u: [f64; 2]) -> Point {
        let (y, part_y) = invert(&self.marginal, u[1]);
        let row = &self.conditional[y * (self.width + 1)..][..=self.width];
        let (x, part_x) = invert(row, u[0]);
        let cos = self.edges[y] + (self.edges[y + 1] - self.edges[y]) * part_y;
        let azimuth = sphere::azimuth(x as f64 + part_x, self.width);
        Point { direction: sphere::direction(azimuth, cos), texel: y * self.width + x }
    }

    /// Radiance of a texel over the density per solid angle with which it is drawn, which is its
    /// luminance over the total.
    pub(super) fn weight(&self, texel: usize) -> DVec3 {
        let radiance = self.environment.texels()[texel];
        match sphere::luminance(radiance) {
            luminance if luminance > 0.0 => radiance.as_dvec3() / luminance * self.total(),
            _ => DVec3::ZERO,
        }
    }
}

/// The interval of ascending sums where a part `u` of the whole is reached, and where in it. Intervals
/// of no weight are not chosen.
fn invert(sums: &[f64], u: f64) -> (usize, f64) {
    let whole = sums[sums.len() - 1];
    let target = u * whole;
    // The first sum above the target ends the interval; beyond the last, its last one of any weight.
    let mut end = sums.partition_point(|sum| *sum <= target);
    if end == sums.len() {
        end = sums.partition_point(|sum| *sum < whole);
    }
    let end = end.max(1);
    let (from, to) = (sums[end - 1], sums[end]);
    (end - 1, ((target - from) / (to - from)).clamp(0.0, 1.0))
}
