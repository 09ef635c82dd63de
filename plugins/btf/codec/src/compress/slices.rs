//! The lower levels: what one view shows of a texel under all lights.

use std::collections::HashMap;

use super::basis::{Basis, Book, Features, dot};
use super::views::{best_scale, error};
use super::{Grid, Limits};
use crate::BtfError;

/// Luminances of a row are stored with this root mean square above black.
pub(super) const BRIGHTNESS: f32 = 80.0;
/// Luma and chroma of black.
const BLACK: f32 = 16.0;
const NEUTRAL: f32 = 128.0;
/// Parts of the decoder: red, green and blue by luma, blue chroma, red chroma.
pub(super) const LUMA: f32 = 1.164_382_8;
const BLUE: [f32; 3] = [0.0, -0.391_761_72, 2.017_234_4];
const RED: [f32; 3] = [1.596_027_3, -0.812_968_75, 0.0];
/// What a chroma's error of 1 makes at most of the root mean square over red, green and blue.
const CHROMA_ERROR: [f32; 2] = [1.235, 1.09];
/// The most rows that the format has room for.
pub(super) const MOST_ROWS: usize = 1 << 20;

/// The most colours: their numbers have 16 bits.
const MOST_COLOURS: usize = 1 << 16;

pub(super) fn too_many(what: &str) -> BtfError {
    BtfError::Unsupported(format!("more than {MOST_ROWS} {what}: allow a larger error"))
}

/// Code-books of luminance, of chroma and of their pairs.
#[derive(Clone, Default)]
pub(super) struct Slices {
    pub(super) alpha: usize,
    pub(super) beta: usize,
    /// Rows of luminance over beta; their sum is about 1.
    pub(super) shapes: Vec<f32>,
    shape_book: Book,
    pub(super) shape_basis: Basis,
    /// For each luminance row and alpha a shape and its scale.
    pub(super) luminance_index: Vec<u32>,
    pub(super) luminance_scale: Vec<f32>,
    /// What that gives above black.
    pub(super) luminances: Vec<f32>,
    pub(super) luminance_book: Book,
    pub(super) luminance_basis: Basis,
    /// For each chroma row and alpha a row of colours.
    pub(super) chroma_index: Vec<u32>,
    /// What that gives, all of the first chroma before all of the second, neutral at 0.
    pub(super) chromas: Vec<f32>,
    pub(super) chroma_book: Book,
    pub(super) chroma_basis: Basis,
    /// For each row of colours and beta a colour.
    pub(super) colour_rows: Vec<u32>,
    colour_row_values: Vec<f32>,
    colour_book: Book,
    pub(super) colour_basis: Basis,
    pub(super) colours: Vec<[f32; 2]>,
    colour_cells: HashMap<[i32; 2], u32>,
    pub(super) pairs: Vec<[u32; 2]>,
    pair_places: HashMap<[u32; 2], u32>,
}

/// A slice to be represented: luma above black, then both chromas, one value a light.
pub(super) struct Target<'a> {
    pub(super) values: &'a [f32],
    /// Its brightness over [`BRIGHTNESS`].
    pub(super) scale: f32,
    pub(super) luminance: Features,
    pub(super) chroma: Features,
}

impl Slices {
    pub(super) fn new(grid: &Grid) -> Self {
        Self { alpha: grid.alpha, beta: grid.beta, ..Self::default() }
    }

    fn area(&self) -> usize {
        self.alpha * self.beta
    }

    pub(super) fn target<'a>(&self, values: &'a [f32]) -> Target<'a> {
        let area = self.area();
        let luma = &values[..area];
        let square = luma.iter().map(|y| y * y).sum::<f32>() / area as f32;
        // Black has no shape: it gets any, with next to no scale.
        let scale = (square.sqrt() / BRIGHTNESS).max(1e-3);
        let [luminance, chroma] = self.normalized(values, scale);
        Target {
            values,
            scale,
            luminance: self.luminance_basis.features(&luminance),
            chroma: self.chroma_basis.features(&weighed(&chroma)),
        }
    }

    /// Luma and chromas of a slice as rows store them.
    pub(super) fn normalized(&self, values: &[f32], scale: f32) -> [Vec<f32>; 2] {
        let (luma, chroma) = values.split_at(self.area());
        [luma, chroma].map(|part| part.iter().map(|value| value / scale).collect())
    }

    /// Among the luminance rows from `first` on, the best if it is within the limit.
    pub(super) fn luminance(&self, target: &Target, first: usize, limits: &Limits) -> Option<u32> {
        let area = self.area();
        let limit = (limits.luminance / LUMA).powi(2) * area as f32;
        let error = |row: &u32| {
            let stored = &self.luminances[*row as usize * area..][..area];
            let differences = target.values.iter().zip(stored).map(|(y, c)| y - target.scale * c);
            differences.map(|d| d * d).sum::<f32>()
        };
        self.luminance_book
            .near(&target.luminance, first)
            .map(|row| (error(&row), row))
            .filter(|(error, _)| *error <= limit)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, row)| row)
    }

    /// Among the chroma rows from `first` on, the best if it is within the limit.
    pub(super) fn chroma(&self, target: &Target, first: usize, limits: &Limits) -> Option<u32> {
        let area = self.area();
        let limit = limits.chroma * limits.chroma * area as f32;
        let error = |row: &u32| {
            let stored = &self.chromas[*row as usize * 2 * area..][..2 * area];
            chroma_error(&target.values[area..], stored, target.scale)
        };
        self.chroma_book
            .near(&target.chroma, first)
            .map(|row| (error(&row), row))
            .filter(|(error, _)| *error <= limit)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, row)| row)
    }

    pub(super) fn add_luminance(&mut self, luma: &[f32], limits: &Limits) -> u32 {
        let row = self.luminance_book.len() as u32;
        self.luminance_book.push(Features::default());
        self.luminance_index.resize((row as usize + 1) * self.alpha, 0);
        self.luminance_scale.resize((row as usize + 1) * self.alpha, 0.0);
        self.luminances.resize((row as usize + 1) * self.area(), 0.0);
        self.set_luminance(row, luma, limits);
        row
    }

    /// Represents a luminance row by shapes, old ones where they are near enough.
    pub(super) fn set_luminance(&mut self, row: u32, luma: &[f32], limits: &Limits) {
        let beta = self.beta;
        let raw: Vec<f32> = luma.iter().map(with_black).collect();
        let limit = (limits.shape / LUMA).powi(2) * beta as f32;
        for (alpha, values) in raw.chunks_exact(beta).enumerate() {
            let features = self.shape_features(values);
            let found = self.nearest_shape(values, &features, limit);
            let (shape, scale) = found.unwrap_or_else(|| {
                let sum: f32 = values.iter().sum();
                self.shapes.extend(values.iter().map(|value| value / sum));
                self.shape_book.push(features);
                (self.shape_book.len() as u32 - 1, sum)
            });
            let at = row as usize * self.alpha + alpha;
            self.luminance_index[at] = shape;
            self.luminance_scale[at] = scale;
            let shape = &self.shapes[shape as usize * beta..][..beta];
            let out = &mut self.luminances[row as usize * luma.len() + alpha * beta..][..beta];
            out.iter_mut().zip(shape).for_each(|(out, value)| *out = scale * value - BLACK);
        }
        let values = &self.luminances[row as usize * luma.len()..][..luma.len()];
        self.luminance_book.set(row as usize, self.luminance_basis.features(values));
    }

    /// Of the shape of length 1, so that scales don't count.
    fn shape_features(&self, values: &[f32]) -> Features {
        let length = dot(values, values).sqrt().max(1e-6);
        self.shape_basis.features(values).map(|feature| feature / length)
    }

    /// The shape that comes nearest with its best scale.
    fn nearest_shape(&self, values: &[f32], features: &Features, limit: f32) -> Option<(u32, f32)> {
        let mut best = (limit, None);
        for row in self.shape_book.near(features, 0) {
            let shape = &self.shapes[row as usize * self.beta..][..self.beta];
            let scale = best_scale(values, shape, dot(shape, shape));
            let error = error(values, shape, scale);
            if error <= best.0 {
                best = (error, Some((row, scale)));
            }
        }
        best.1
    }

    pub(super) fn add_chroma(&mut self, chroma: &[f32], limits: &Limits) -> u32 {
        let row = self.chroma_book.len() as u32;
        self.chroma_book.push(Features::default());
        self.chroma_index.resize((row as usize + 1) * self.alpha, 0);
        self.chromas.resize((row as usize + 1) * 2 * self.area(), 0.0);
        self.set_chroma(row, chroma, limits);
        row
    }

    /// Represents a chroma row by rows of colours.
    pub(super) fn set_chroma(&mut self, row: u32, chroma: &[f32], limits: &Limits) {
        let (alpha_count, beta, area) = (self.alpha, self.beta, self.area());
        for alpha in 0..alpha_count {
            let from = alpha * beta;
            let mut values = vec![0.0; 2 * beta];
            values[..beta].copy_from_slice(&chroma[from..from + beta]);
            values[beta..].copy_from_slice(&chroma[area + from..area + from + beta]);
            let features = self.colour_basis.features(&weighed(&values));
            let found = self.nearest_colours(&values, &features, limits.colours);
            let colours = found.unwrap_or_else(|| {
                self.colour_book.push(features);
                for at in 0..beta {
                    let colour = self.colour([values[at], values[beta + at]], limits.colour_step);
                    self.colour_rows.push(colour);
                }
                let row = self.colour_rows.len() / beta - 1;
                let colours = &self.colour_rows[row * beta..];
                for channel in 0..2 {
                    let values = colours.iter().map(|c| self.colours[*c as usize][channel]);
                    self.colour_row_values.extend(values);
                }
                row as u32
            });
            self.chroma_index[row as usize * alpha_count + alpha] = colours;
            let stored = &self.colour_row_values[colours as usize * 2 * beta..][..2 * beta];
            let out = &mut self.chromas[row as usize * 2 * area..][..2 * area];
            out[from..from + beta].copy_from_slice(&stored[..beta]);
            out[area + from..area + from + beta].copy_from_slice(&stored[beta..]);
        }
        let values = weighed(&self.chromas[row as usize * 2 * area..][..2 * area]);
        self.chroma_book.set(row as usize, self.chroma_basis.features(&values));
    }

    fn nearest_colours(&self, values: &[f32], features: &Features, limit: f32) -> Option<u32> {
        let length = values.len();
        let mut best = (limit * limit * self.beta as f32, None);
        for row in self.colour_book.near(features, 0) {
            let stored = &self.colour_row_values[row as usize * length..][..length];
            let error = chroma_error(values, stored, 1.0);
            if error <= best.0 {
                best = (error, Some(row));
            }
        }
        best.1
    }

    /// A colour on a grid of `step`; the nearest old one when 16 bits can't number another.
    fn colour(&mut self, chroma: [f32; 2], step: f32) -> u32 {
        let cell = chroma.map(|value| (value / step).round() as i32);
        let colours = &mut self.colours;
        if colours.len() == MOST_COLOURS && !self.colour_cells.contains_key(&cell) {
            let distance = |colour: &[f32; 2]| {
                (colour[0] - chroma[0]).powi(2) + (colour[1] - chroma[1]).powi(2)
            };
            let nearest = (0..).zip(colours.iter());
            let nearest = nearest.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
            return nearest.map_or(0, |(place, _)| place);
        }
        *self.colour_cells.entry(cell).or_insert_with(|| {
            colours.push(cell.map(|value| value as f32 * step));
            colours.len() as u32 - 1
        })
    }

    pub(super) fn pair(&mut self, luminance: u32, chroma: u32) -> u32 {
        let pairs = &mut self.pairs;
        *self.pair_places.entry([luminance, chroma]).or_insert_with(|| {
            pairs.push([luminance, chroma]);
            pairs.len() as u32 - 1
        })
    }

    /// Red, green and blue of a pair, all of one channel before the next.
    pub(super) fn decode(&self, pair: u32, out: &mut [f32]) {
        let area = self.area();
        let [luminance, chroma] = self.pairs[pair as usize].map(|row| row as usize);
        let luma = &self.luminances[luminance * area..][..area];
        let (blue, red) = self.chromas[chroma * 2 * area..][..2 * area].split_at(area);
        for (channel, out) in out.chunks_exact_mut(area).enumerate() {
            let (by_blue, by_red) = (BLUE[channel], RED[channel]);
            for (((out, y), cb), cr) in out.iter_mut().zip(luma).zip(blue).zip(red) {
                *out = (LUMA * y + by_blue * cb + by_red * cr).max(0.0);
            }
        }
    }

    /// Starts anew with given luminance and chroma rows, in which each pair keeps its place.
    pub(super) fn rebuild(&mut self, luma: &[f32], chroma: &[f32], limits: &Limits) {
        let area = self.area();
        self.shapes.clear();
        self.shape_book = Book::default();
        self.colour_rows.clear();
        self.colour_book = Book::default();
        self.colour_row_values.clear();
        self.colours.clear();
        self.colour_cells.clear();
        for (row, luma) in (0_u32..).zip(luma.chunks_exact(area)) {
            self.set_luminance(row, luma, limits);
        }
        for (row, chroma) in (0_u32..).zip(chroma.chunks_exact(2 * area)) {
            self.set_chroma(row, chroma, limits);
        }
    }

    /// Keeps the given pairs, in order, and the rows that they use.
    pub(super) fn prune(&mut self, kept: &[u32], limits: &Limits) {
        let area = self.area();
        let (mut luma, mut chroma) = (Vec::new(), Vec::new());
        let (mut luma_places, mut chroma_places) = (HashMap::new(), HashMap::new());
        let mut pairs = Vec::with_capacity(kept.len());
        for pair in kept {
            let [l, c] = self.pairs[*pair as usize];
            let next = luma_places.len() as u32;
            let l = *luma_places.entry(l).or_insert_with(|| {
                luma.extend_from_slice(&self.luminances[l as usize * area..][..area]);
                next
            });
            let next = chroma_places.len() as u32;
            let c = *chroma_places.entry(c).or_insert_with(|| {
                chroma.extend_from_slice(&self.chromas[c as usize * 2 * area..][..2 * area]);
                next
            });
            pairs.push([l, c]);
        }
        let mut new = Self {
            alpha: self.alpha,
            beta: self.beta,
            colour_basis: std::mem::take(&mut self.colour_basis),
            shape_basis: std::mem::take(&mut self.shape_basis),
            luminance_basis: std::mem::take(&mut self.luminance_basis),
            chroma_basis: std::mem::take(&mut self.chroma_basis),
            ..Self::default()
        };
        for luma in luma.chunks_exact(area) {
            new.add_luminance(luma, limits);
        }
        for chroma in chroma.chunks_exact(2 * area) {
            new.add_chroma(chroma, limits);
        }
        new.pair_places = (0..).zip(&pairs).map(|(place, pair)| (*pair, place)).collect();
        new.pairs = pairs;
        *self = new;
    }

    pub(super) fn shape_count(&self) -> usize {
        self.shape_book.len()
    }

    pub(super) fn check(&self) -> Result<(), BtfError> {
        for (count, what) in [
            (self.pairs.len(), "slices"),
            (self.shape_count(), "shapes"),
            (self.luminance_book.len(), "rows of luminances"),
        ] {
            if count > MOST_ROWS {
                return Err(too_many(what));
            }
        }
        Ok(())
    }
}

/// Luma as shapes have it.
pub(super) fn with_black(luma: &f32) -> f32 {
    (luma + BLACK).max(1e-3)
}

/// The decoder's offsets for tables.
pub(super) fn stored_chroma(colour: [f32; 2]) -> [f32; 2] {
    colour.map(|value| value + NEUTRAL)
}

/// Sum of squares of what the difference makes of red, green and blue.
fn chroma_error(goal: &[f32], chroma: &[f32], scale: f32) -> f32 {
    let (blue, red) = chroma.split_at(chroma.len() / 2);
    let (goal_blue, goal_red) = goal.split_at(blue.len());
    let [by_blue, by_red] = CHROMA_ERROR.map(|weight| weight * weight);
    by_blue * error(goal_blue, blue, scale) + by_red * error(goal_red, red, scale)
}

/// Chromas in units of the error that they make.
pub(super) fn weighed(chroma: &[f32]) -> Vec<f32> {
    let (blue, red) = chroma.split_at(chroma.len() / 2);
    let blue = blue.iter().map(|value| CHROMA_ERROR[0] * value);
    blue.chain(red.iter().map(|value| CHROMA_ERROR[1] * value)).collect()
}
