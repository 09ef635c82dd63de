//! A picture of any size, taken row by row, averaged down to a bounded map.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use crate::layout::Shape;
use crate::projection::Projection;
use crate::{Environment, EnvironmentError, Layout, Repairs, sphere};

/// Sides of a picture, in texels.
const LONGEST_SIDE: u32 = 1 << 16;
/// Texels of a picture: 16k x 16k. A compressed file of a few bytes could hold any number.
const MOST_TEXELS: u64 = 1 << 28;
/// A map has at most so many texels each way.
const MOST: [u32; 2] = [2048, 1024];
/// So has an angular map, and a face of a cube, before they are unrolled.
const MOST_ANGULAR: u32 = 2048;
const MOST_FACE: u32 = 512;
/// Greater values count as infinite: sums of them must fit a single float.
const GREATEST: f32 = 1e30;

/// Takes a picture and makes a map.
///
/// What it adds up is flux, radiance times solid angle, so that energy is kept whatever the sizes.
pub(crate) struct Shrink {
    shape: Shape,
    /// None for an equirectangular picture.
    projection: Option<Projection>,
    target: [usize; 2],
    columns: Vec<Overlap>,
    rows: Vec<Row>,
    flux: Vec<DVec3>,
    /// Solid angle of infinite values a target and channel; empty as long as there are none.
    infinite: Vec<DVec3>,
    greatest: f32,
    repairs: Repairs,
}

/// The one or two targets that a column or row of the source falls into.
#[derive(Clone, Copy)]
struct Overlap {
    first: usize,
    /// Part that falls into the first; the rest falls into the next one.
    part: f64,
}

#[derive(Clone, Copy)]
struct Row {
    to: Overlap,
    /// Solid angle of one texel of an equirectangular picture.
    solid_angle: f64,
}

impl Overlap {
    /// Of column `at` of `from` columns, shrunk to `to`.
    fn new(at: usize, from: usize, to: usize) -> Self {
        let first = at * to / from;
        // Where the first target ends, in columns of the source.
        let end = (first + 1) as f64 * from as f64 / to as f64;
        Self { first, part: (end - at as f64).min(1.0) }
    }

    fn targets(self) -> impl Iterator<Item = (usize, f64)> {
        let second = (self.part < 1.0).then_some((self.first + 1, 1.0 - self.part));
        std::iter::once((self.first, self.part)).chain(second)
    }
}

impl Shrink {
    /// For a picture of this size.
    pub(crate) fn new(size: [u32; 2], layout: Layout) -> Result<Self, EnvironmentError> {
        let [width, height] = size;
        if size.contains(&0) || size.iter().any(|side| *side > LONGEST_SIDE) {
            let what = format!("{width} x {height} texels: each side must be 1 to {LONGEST_SIDE}");
            return Err(EnvironmentError::Size(what));
        }
        if u64::from(width) * u64::from(height) > MOST_TEXELS {
            let what = format!("{width} x {height} texels are more than {MOST_TEXELS}");
            return Err(EnvironmentError::Size(what));
        }
        let shape = layout.resolve(size)?;
        let target = match shape {
            Shape::Equirect => [width.min(MOST[0]), height.min(MOST[1])],
            Shape::Angular => [width.min(MOST_ANGULAR); 2],
            Shape::Cube(cube) => {
                let squares = cube.squares();
                squares.map(|count| count * (width / squares[0]).min(MOST_FACE))
            }
        };
        let [target, [width, height]] = [target, size].map(|size| size.map(|side| side as usize));
        let projection = Projection::new(shape, [width, height]);
        let columns = (0..width).map(|x| Overlap::new(x, width, target[0])).collect();
        let edges = sphere::row_edges(height);
        let target_edges = sphere::row_edges(target[1]);
        let rows = (0..height)
            .map(|y| {
                let mut to = Overlap::new(y, height, target[1]);
                let whole = edges[y] - edges[y + 1];
                if to.part < 1.0 && projection.is_none() {
                    to.part = ((edges[y] - target_edges[to.first + 1]) / whole).clamp(0.0, 1.0);
                }
                Row { to, solid_angle: whole * TAU / width as f64 }
            })
            .collect();
        Ok(Self {
            shape,
            projection,
            target,
            columns,
            rows,
            flux: vec![DVec3::ZERO; target[0] * target[1]],
            infinite: Vec::new(),
            greatest: 0.0,
            repairs: Repairs::default(),
        })
    }

    /// Adds texels of row `y`, from column `x` on.
    pub(crate) fn row(&mut self, y: usize, x: usize, texels: &[Vec3]) {
        let row = self.rows[y];
        for (x, texel) in (x..).zip(texels) {
            let column = self.columns[x];
            let solid_angle = match &self.projection {
                None => row.solid_angle,
                Some(projection) => projection.solid_angle(x, y),
            };
            if solid_angle == 0.0 {
                continue;
            }
            let (radiance, infinite) = self.repair(*texel);
            for (to_y, part_y) in row.to.targets() {
                for (to_x, part_x) in column.targets() {
                    let (at, weight) = (to_y * self.target[0] + to_x, part_x * part_y);
                    self.flux[at] += radiance * (weight * solid_angle);
                    if infinite != DVec3::ZERO {
                        self.infinite.resize(self.flux.len(), DVec3::ZERO);
                        self.infinite[at] += infinite * (weight * solid_angle);
                    }
                }
            }
        }
    }

    /// What of a value is radiance, and 1 where it is infinite.
    fn repair(&mut self, texel: Vec3) -> (DVec3, DVec3) {
        if texel.cmpge(Vec3::ZERO).all() && texel.cmple(Vec3::splat(GREATEST)).all() {
            self.greatest = self.greatest.max(texel.max_element());
            return (texel.as_dvec3(), DVec3::ZERO);
        }
        let (mut radiance, mut infinite) = (DVec3::ZERO, DVec3::ZERO);
        for channel in 0..3 {
            let value = texel[channel];
            if value.is_nan() {
                self.repairs.nan += 1;
            } else if value < 0.0 {
                self.repairs.negative += 1;
            } else if value > GREATEST {
                self.repairs.infinite += 1;
                infinite[channel] = 1.0;
            } else {
                self.greatest = self.greatest.max(value);
                radiance[channel] = f64::from(value);
            }
        }
        (radiance, infinite)
    }

    /// The map.
    pub(crate) fn finish(mut self) -> Environment {
        for (flux, infinite) in self.flux.iter_mut().zip(&self.infinite) {
            *flux += *infinite * f64::from(self.greatest);
        }
        let (width, height, flux) = match Projection::new(self.shape, self.target) {
            None => (self.target[0], self.target[1], self.flux),
            Some(projection) => projection.unroll(&self.flux),
        };
        let edges = sphere::row_edges(height);
        let texels = (flux.chunks_exact(width).zip(edges.windows(2)))
            .flat_map(|(row, cos)| {
                let solid_angle = (cos[0] - cos[1]) * TAU / width as f64;
                row.iter().map(move |flux| (*flux / solid_angle).as_vec3())
            })
            .collect();
        Environment::new(width, height, texels, self.repairs)
    }
}
