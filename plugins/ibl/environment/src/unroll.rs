//! Cubes and angular maps become equirectangular.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::{projection::Projection, sphere};

/// A texel looks in so many directions each way.
const SAMPLES: usize = 4;
/// Energy is kept for each block of so many texels of the source each way.
const BLOCK: usize = 8;
/// Rows that are sampled at once.
const ROWS: usize = 32;

impl Projection {
    /// An equirectangular map that holds the same flux: width, height and flux of its texels.
    ///
    /// A texel is the mean of what lies in several directions within it. How much of the source that
    /// catches is a matter of chance for a small, bright one; so the flux of each block of the source
    /// is made what it was.
    pub(crate) fn unroll(&self, flux: &[DVec3]) -> (usize, usize, Vec<DVec3>) {
        let height = self.rows_round().clamp(64, 1024);
        let width = 2 * height;
        let weights = row_weights(width, height);
        let radiance: Vec<DVec3> = (0..flux.len())
            .into_par_iter()
            .map(|at| {
                let solid_angle = self.solid_angle(at % self.width, at / self.width);
                if solid_angle > 0.0 { flux[at] / solid_angle } else { DVec3::ZERO }
            })
            .collect();

        let mut blocks = Blocks::new(self, flux);
        self.each_row(width, height, |y, sources| {
            for (at, source) in sources.iter().enumerate() {
                let source = *source as usize;
                blocks.catch(source, radiance[source] * weights[y][at / SAMPLES / width]);
            }
        });
        let factors = blocks.factors();
        let mut unrolled = vec![DVec3::ZERO; width * height];
        self.each_row(width, height, |y, sources| {
            for (at, source) in sources.iter().enumerate() {
                let (x, source) = (at / SAMPLES % width, *source as usize);
                let caught = radiance[source] * weights[y][at / SAMPLES / width];
                unrolled[y * width + x] += caught * factors[blocks.of(source)];
            }
        });
        for (source, missed) in blocks.missed(&factors) {
            let direction = self.direction(source % self.width, source / self.width);
            let (x, y) = sphere::texel(direction, width, height);
            unrolled[y * width + x] += missed;
        }
        (width, height, unrolled)
    }

    /// Calls `take` for each row with the source's texels that its samples hit: rows of samples from
    /// the top, each from the left.
    fn each_row(&self, width: usize, height: usize, mut take: impl FnMut(usize, &[u32])) {
        let step = 1.0 / (SAMPLES * height) as f64;
        let turns: Vec<DVec2> = (0..width * SAMPLES)
            .map(|x| {
                let azimuth = sphere::azimuth((x as f64 + 0.5) / SAMPLES as f64, width);
                DVec2::new(azimuth.sin(), -azimuth.cos())
            })
            .collect();
        for start in (0..height).step_by(ROWS) {
            let rows: Vec<Vec<u32>> = (start..(start + ROWS).min(height))
                .into_par_iter()
                .map(|y| {
                    let lines = y * SAMPLES..(y + 1) * SAMPLES;
                    let samples = lines.flat_map(|line| {
                        let (sin, cos) = (PI * (line as f64 + 0.5) * step).sin_cos();
                        turns.iter().map(move |t| DVec3::new(t.x * sin, cos, t.y * sin))
                    });
                    samples.map(|direction| self.texel(direction) as u32).collect()
                })
                .collect();
            for (y, row) in (start..).zip(rows) {
                take(y, &row);
            }
        }
    }
}

/// Solid angle of a sample in each line of samples of each row.
fn row_weights(width: usize, height: usize) -> Vec<[f64; SAMPLES]> {
    let edges = sphere::row_edges(height * SAMPLES);
    let turn = TAU / (width * SAMPLES) as f64;
    let weight = |line: usize| (edges[line] - edges[line + 1]) * turn;
    (0..height).map(|y| std::array::from_fn(|line| weight(y * SAMPLES + line))).collect()
}

/// Flux of blocks of the source, as it is and as samples catch it.
struct Blocks {
    width: usize,
    columns: usize,
    flux: Vec<DVec3>,
    caught: Vec<DVec3>,
    /// The texel of most flux.
    brightest: Vec<usize>,
}

impl Blocks {
    fn new(projection: &Projection, flux: &[DVec3]) -> Self {
        let columns = projection.width.div_ceil(BLOCK);
        let count = columns * projection.height.div_ceil(BLOCK);
        let mut blocks = Self {
            width: projection.width,
            columns,
            flux: vec![DVec3::ZERO; count],
            caught: vec![DVec3::ZERO; count],
            brightest: vec![usize::MAX; count],
        };
        for (at, texel) in flux.iter().enumerate().filter(|(_, texel)| **texel != DVec3::ZERO) {
            let block = blocks.of(at);
            blocks.flux[block] += *texel;
            let brightest = &mut blocks.brightest[block];
            if flux.get(*brightest).is_none_or(|other| other.element_sum() < texel.element_sum()) {
                *brightest = at;
            }
        }
        blocks
    }

    fn of(&self, texel: usize) -> usize {
        texel / self.width / BLOCK * self.columns + texel % self.width / BLOCK
    }

    fn catch(&mut self, texel: usize, flux: DVec3) {
        let block = self.of(texel);
        self.caught[block] += flux;
    }

    /// What makes the caught flux that of the source, a block and channel.
    fn factors(&self) -> Vec<DVec3> {
        let factor = |flux: f64, caught: f64| if caught > 0.0 { flux / caught } else { 0.0 };
        let pairs = self.flux.iter().zip(&self.caught);
        pairs
            .map(|(flux, caught)| {
                DVec3::from_array(std::array::from_fn(|c| factor(flux[c], caught[c])))
            })
            .collect()
    }

    /// Flux of which nothing was caught, and from where.
    fn missed<'a>(&'a self, factors: &'a [DVec3]) -> impl Iterator<Item = (usize, DVec3)> + 'a {
        (0..factors.len()).filter(|block| self.brightest[*block] != usize::MAX).map(|block| {
            let missed =
                DVec3::select(factors[block].cmpeq(DVec3::ZERO), self.flux[block], DVec3::ZERO);
            (self.brightest[block], missed)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Cube, Shape};

    #[test]
    fn what_is_unrolled_has_the_same_flux() {
        for (shape, size) in [
            (Shape::Angular, [48, 48]),
            (Shape::Cube(Cube::LyingCross), [48, 36]),
            (Shape::Cube(Cube::StandingCross), [36, 48]),
        ] {
            let projection = Projection::new(shape, size).unwrap();
            let mut flux: Vec<DVec3> = (0..size[0] * size[1])
                .map(|at| projection.solid_angle(at % size[0], at / size[0]) * DVec3::ONE)
                .collect();
            let bright = projection.texel(DVec3::new(0.3, 0.8, 0.5));
            flux[bright] += DVec3::new(1e6, 0.0, 1.0);
            let (width, height, unrolled) = projection.unroll(&flux);
            let sums = [&flux, &unrolled].map(|all| all.iter().sum::<DVec3>());
            assert!((sums[1] / sums[0] - 1.0).abs().max_element() < 1e-12, "{shape:?}: {sums:?}");
            // No holes, and nothing uneven that would be seen.
            let edges = sphere::row_edges(height);
            for (at, flux) in unrolled.iter().enumerate() {
                let y = at / width;
                let green = flux.y / ((edges[y] - edges[y + 1]) * TAU / width as f64);
                assert!((0.8..1.25).contains(&green), "{shape:?} {} {y}: {green}", at % width);
            }
        }
    }
}
