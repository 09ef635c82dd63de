//! Sums over rectangles of the map, by a table.

use std::f64::consts::TAU;

use glam::{DVec3, DVec4, Vec3};
use rayon::prelude::*;

use super::worth::Worth;
use crate::{Environment, sphere};

/// At least so many cells, whatever the map has: a light's place is told within a cell only roughly.
const FEWEST: [usize; 2] = [128, 64];

/// Cells of the map (texels, or parts of them where there are few), with a summed-area table.
///
/// Column coordinates go on beyond the right edge into the next turn; the fraction of a row
/// coordinate is one of the row's solid angle.
pub(super) struct Sums<'a> {
    environment: &'a Environment,
    parts: [usize; 2],
    pub(super) width: usize,
    pub(super) height: usize,
    /// Cosines at the edges of the rows.
    edges: Vec<f64>,
    /// (V, E) above and to the left of each corner of a cell: the integrals of luminance times its
    /// worth times the unit vector, and without that.
    table: Vec<DVec4>,
    black: bool,
}

/// From (x0, y0) to (x1, y1), in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rect {
    pub(super) x: [f64; 2],
    pub(super) y: [f64; 2],
}

/// What a region sends.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sent {
    /// Integral of radiance a channel.
    pub(super) energy: DVec3,
    /// Integral of luminance times the unit vector; of the unit vector alone for a black map.
    pub(super) vector: DVec3,
}

impl<'a> Sums<'a> {
    pub(super) fn new(environment: &'a Environment, worth: &Worth) -> Self {
        let parts = environment.parts(FEWEST);
        let width = environment.width() as usize * parts[0];
        let height = environment.height() as usize * parts[1];
        let black = environment.texels().iter().all(|texel| *texel == Vec3::ZERO);
        let mut sums = Self {
            environment,
            parts,
            width,
            height,
            edges: sphere::row_edges(height),
            table: Vec::new(),
            black,
        };
        sums.table = sums.table(worth);
        sums
    }

    fn table(&self, worth: &Worth) -> Vec<DVec4> {
        let azimuth = |x: usize| sphere::azimuth(x as f64, self.width);
        let sectors: Vec<_> =
            (0..self.width).map(|x| sphere::sector(azimuth(x), azimuth(x + 1))).collect();
        let step = TAU / self.width as f64;
        let stride = self.width + 1;
        let mut table = vec![DVec4::ZERO; stride * (self.height + 1)];
        table.par_chunks_exact_mut(stride).skip(1).enumerate().for_each(|(y, row)| {
            let [top, bottom] = [self.edges[y], self.edges[y + 1]];
            let band = sphere::band(top, bottom);
            let mut sum = DVec4::ZERO;
            for x in 0..self.width {
                let at = [x, y].map(|at| at as f64 + 0.5);
                let worth = worth.at(at[0] / self.width as f64, at[1] / self.height as f64);
                let (sector, weight) = (sectors[x], worth * self.luminance(x, y));
                let vector = DVec3::new(band.x * sector.x, band.y * step, band.x * sector.y);
                sum += weight * vector.extend((top - bottom) * step);
                row[x + 1] = sum;
            }
        });
        for at in stride..table.len() {
            let above = table[at - stride];
            table[at] += above;
        }
        table
    }

    fn radiance(&self, x: usize, y: usize) -> DVec3 {
        let [x, y] = [x / self.parts[0], y / self.parts[1]];
        self.environment.texels()[y * self.environment.width() as usize + x].as_dvec3()
    }

    fn luminance(&self, x: usize, y: usize) -> f64 {
        if self.black { 1.0 } else { sphere::luminance(self.radiance(x, y).as_vec3()) }
    }

    /// The sphere, cut open at a column coordinate.
    pub(super) fn whole(&self, from: f64) -> Rect {
        Rect { x: [from, from + self.width as f64], y: [0.0, self.height as f64] }
    }

    /// (V, E) of a rectangle: E is exact, V between the corners of cells interpolated.
    pub(super) fn of(&self, rect: Rect) -> DVec4 {
        let [x0, x1] = rect.x;
        let [y0, y1] = rect.y;
        self.up_to(x1, y1) - self.up_to(x0, y1) - self.up_to(x1, y0) + self.up_to(x0, y0)
    }

    fn up_to(&self, x: f64, y: f64) -> DVec4 {
        let width = self.width as f64;
        if x > width {
            return self.up_to(width, y) + self.up_to(x - width, y);
        }
        let cell = |at: f64, count: usize| {
            let first = (at as usize).min(count - 1);
            (first, at - first as f64)
        };
        let ((x, part_x), (y, part_y)) = (cell(x, self.width), cell(y, self.height));
        let stride = self.width + 1;
        let corner = |x: usize, y: usize| self.table[y * stride + x];
        let row = |y: usize| {
            let (left, right) = (corner(x, y), corner(x + 1, y));
            left + (right - left) * part_x
        };
        let (above, below) = (row(y), row(y + 1));
        above + (below - above) * part_y
    }

    /// The column coordinate that leaves the part `u` of the rectangle's E to its left.
    pub(super) fn column_at(&self, rect: Rect, u: f64) -> f64 {
        let left = |x: f64| self.of(Rect { x: [rect.x[0], x], ..rect }).w;
        find(rect.x, u * left(rect.x[1]), left)
    }

    /// The row coordinate that leaves the part `u` of the rectangle's E above it.
    pub(super) fn row_at(&self, rect: Rect, u: f64) -> f64 {
        let above = |y: f64| self.of(Rect { y: [rect.y[0], y], ..rect }).w;
        find(rect.y, u * above(rect.y[1]), above)
    }

    /// A point of a rectangle by the distribution, for a point of the unit square.
    pub(super) fn sample(&self, rect: Rect, u: [f64; 2]) -> DVec3 {
        let y = self.row_at(rect, u[1]);
        let row = (y as usize).min(self.height - 1) as f64;
        let row = Rect { y: [row.max(rect.y[0]), (row + 1.0).min(rect.y[1])], ..rect };
        self.direction(self.column_at(row, u[0]), y)
    }

    /// The direction of column and row coordinates.
    fn direction(&self, x: f64, y: f64) -> DVec3 {
        sphere::direction(sphere::azimuth(x, self.width), self.cos(y))
    }

    /// Cosine of the polar angle at a row coordinate.
    fn cos(&self, y: f64) -> f64 {
        let row = (y as usize).min(self.height - 1);
        self.edges[row] + (self.edges[row + 1] - self.edges[row]) * (y - row as f64)
    }

    /// What a rectangle sends, exactly.
    pub(super) fn sent(&self, rect: Rect) -> Sent {
        let mut sent = Sent::default();
        let columns: Vec<_> = pieces(rect.x)
            .map(|[from, to]| {
                let [a, b] = [from, to].map(|x| sphere::azimuth(x, self.width));
                (from as usize % self.width / self.parts[0], b - a, sphere::sector(a, b))
            })
            .collect();
        for [from, to] in pieces(rect.y) {
            let row = (from as usize).min(self.height - 1) / self.parts[1];
            let width = self.environment.width() as usize;
            let texels = &self.environment.texels()[row * width..][..width];
            // Over the row: radiance times azimuth, times x and times z.
            let [mut turned, mut right, mut back] = [DVec3::ZERO; 3];
            let mut vector = DVec3::ZERO;
            for (x, turn, sector) in &columns {
                let radiance = texels[*x].as_dvec3();
                turned += radiance * *turn;
                right += radiance * sector.x;
                back += radiance * sector.y;
                vector += DVec3::new(sector.x, *turn, sector.y);
            }
            let [top, bottom] = [from, to].map(|y| self.cos(y));
            let band = sphere::band(top, bottom);
            let band = DVec3::new(band.x, band.y, band.x);
            sent.energy += turned * (top - bottom);
            let luminance = |rgb: DVec3| rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722));
            sent.vector += band
                * if self.black {
                    vector
                } else {
                    DVec3::from([right, turned, back].map(luminance))
                };
        }
        sent
    }
}

/// An interval, cut at whole numbers.
fn pieces([from, to]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let first = from as usize;
    let last = (to.ceil() as usize).max(first + 1);
    (first..last).map(move |at| [from.max(at as f64), to.min((at + 1) as f64)])
}

/// Where in an interval a rising function, linear between whole numbers, reaches a value.
fn find([from, to]: [f64; 2], value: f64, function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (from, to);
    let (mut below, mut above) = (from as usize, to.ceil() as usize);
    while above - below > 1 {
        let middle = below + (above - below) / 2;
        if function(middle as f64) < value {
            (below, low) = (middle, middle as f64);
        } else {
            (above, high) = (middle, middle as f64);
        }
    }
    let [at_low, at_high] = [low, high].map(function);
    let part = if at_high > at_low { (value - at_low) / (at_high - at_low) } else { 0.5 };
    low + (high - low) * part.clamp(0.0, 1.0)
}
