//! What light is worth: more where little else lights a surface that faces it.
//!
//! An error that is small beside all light is large for a surface that sees only the map's dark side.
//! So luminance is divided by a power of the irradiance of a surface that faces it.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use crate::{Environment, sphere};

/// Columns and rows of the table.
const TABLE: [usize; 2] = [32, 16];
/// The map is summed up to so many cells for the table's irradiances.
const CELLS: [usize; 2] = [128, 64];
/// 0 is worth by luminance alone; 1 makes a share of each surface's light worth the same.
const POWER: f64 = 0.75;
/// Part of the mean irradiance that every surface has at least.
const FLOOR: f64 = 1e-3;

/// Factors of luminance by direction, smooth over the sphere.
pub(super) struct Worth(Vec<f64>);

impl Worth {
    /// The same everywhere.
    pub(super) fn even() -> Self {
        Self(vec![1.0; TABLE[0] * TABLE[1]])
    }

    pub(super) fn new(environment: &Environment) -> Self {
        let cells = cells(environment);
        let irradiance: Vec<f64> = (0..TABLE[0] * TABLE[1])
            .into_par_iter()
            .map(|at| {
                let normal = direction(at, TABLE);
                cells.iter().map(|cell| cell.dot(normal).max(0.0)).sum()
            })
            .collect();
        let mean = irradiance.iter().sum::<f64>() / irradiance.len() as f64;
        if mean <= 0.0 {
            return Self::even();
        }
        Self(irradiance.iter().map(|there| (there / mean + FLOOR).powf(-POWER)).collect())
    }

    /// At a column and row coordinate, each a part of the map's width and height.
    pub(super) fn at(&self, u: f64, v: f64) -> f64 {
        let [x, y] = [u * TABLE[0] as f64 - 0.5, v * TABLE[1] as f64 - 0.5];
        let (left, top) = (x.floor(), y.floor());
        let value = |right: f64, down: f64| {
            let x = (left + right).rem_euclid(TABLE[0] as f64) as usize % TABLE[0];
            let y = (top + down).clamp(0.0, (TABLE[1] - 1) as f64) as usize;
            self.0[y * TABLE[0] + x]
        };
        let row = |down: f64| {
            let (from, to) = (value(0.0, down), value(1.0, down));
            from + (to - from) * (x - left)
        };
        row(0.0) + (row(1.0) - row(0.0)) * (y - top)
    }
}

/// Luminous energy of parts of the map, along their directions.
fn cells(environment: &Environment) -> Vec<DVec3> {
    let [width, height] = [environment.width() as usize, environment.height() as usize];
    let edges = sphere::row_edges(height);
    let mut sums = vec![0.0; CELLS[0] * CELLS[1]];
    for (y, row) in environment.texels().chunks_exact(width).enumerate() {
        let to = &mut sums[y * CELLS[1] / height * CELLS[0]..][..CELLS[0]];
        for (x, texel) in row.iter().enumerate() {
            to[x * CELLS[0] / width] += sphere::luminance(*texel) * (edges[y] - edges[y + 1]);
        }
    }
    sums.iter().enumerate().map(|(at, sum)| *sum * direction(at, CELLS)).collect()
}

/// The direction of the middle of a cell.
fn direction(at: usize, [width, height]: [usize; 2]) -> DVec3 {
    let [x, y] = [at % width, at / width].map(|at| at as f64 + 0.5);
    sphere::direction(sphere::azimuth(x, width), (PI * y / height as f64).cos())
}
