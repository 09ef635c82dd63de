//! Between two passes: rows move into the middle of what they stand for.
//!
//! Lloyd's step (1982, "Least Squares Quantization in PCM", IEEE Trans. Inf. Theory 28(2)) for the
//! rows of luminance and chroma, weighed by the scales with which they are used.

use std::collections::HashMap;

use super::Limits;
use super::books::{Books, Texel};

/// Sums over all uses of the rows.
pub(super) struct Centres {
    luma: Vec<f32>,
    luma_weight: Vec<f32>,
    chroma: Vec<f32>,
    chroma_weight: Vec<f32>,
}

impl Centres {
    pub(super) fn new() -> Self {
        Self { luma: vec![], luma_weight: vec![], chroma: vec![], chroma_weight: vec![] }
    }

    /// Counts a texel that has been given rows.
    pub(super) fn add(&mut self, books: &Books, texel: &Texel, (row, scale): (u32, f32)) {
        let area = books.grid().slice();
        let slices = &books.slices;
        self.luma.resize(slices.luminances.len(), 0.0);
        self.luma_weight.resize(slices.luminances.len() / area, 0.0);
        self.chroma.resize(slices.chromas.len(), 0.0);
        self.chroma_weight.resize(slices.chromas.len() / area / 2, 0.0);
        let mut view = 0;
        let (elevations, by_azimuth) = books.azimuths.row(row);
        for (row, azimuth_scale) in elevations.iter().zip(by_azimuth) {
            let (pairs, by_elevation) = books.elevations.row(*row);
            for (pair, elevation_scale) in pairs.iter().zip(by_elevation) {
                let weight = scale * azimuth_scale * elevation_scale;
                let (luma, chroma) = books.video(texel, view).split_at(area);
                let [luminance, colour] = slices.pairs[*pair as usize].map(|row| row as usize);
                let sums = &mut self.luma[luminance * area..][..area];
                sums.iter_mut().zip(luma).for_each(|(sum, value)| *sum += weight * value);
                self.luma_weight[luminance] += weight * weight;
                let sums = &mut self.chroma[colour * 2 * area..][..2 * area];
                sums.iter_mut().zip(chroma).for_each(|(sum, value)| *sum += weight * value);
                self.chroma_weight[colour] += weight * weight;
                view += 1;
            }
        }
    }

    /// Moves the rows.
    pub(super) fn apply(mut self, books: &mut Books, limits: &Limits) {
        let area = books.grid().slice();
        for (sums, old, weights, length) in [
            (&mut self.luma, &books.slices.luminances, &self.luma_weight, area),
            (&mut self.chroma, &books.slices.chromas, &self.chroma_weight, 2 * area),
        ] {
            let rows = sums.chunks_exact_mut(length).zip(old.chunks_exact(length));
            for ((sums, old), weight) in rows.zip(weights) {
                // Too little light to tell.
                if *weight < 1e-4 {
                    sums.copy_from_slice(old);
                } else {
                    sums.iter_mut().for_each(|sum| *sum /= weight);
                }
            }
        }
        books.slices.rebuild(&self.luma, &self.chroma, limits);
        let mut colours = vec![0.0; books.grid().theta * 3 * area];
        for row in 0..books.elevations.len() as u32 {
            books.decode_elevations(row, &mut colours);
            books.elevations.set_colours(row, &colours);
        }
    }
}

impl Books {
    /// Forgets which texel has which row.
    pub(super) fn forget_texels(&mut self) {
        self.texels.clear();
        let mut azimuths = super::views::Rows::new(self.azimuths.columns);
        azimuths.basis = std::mem::take(&mut self.azimuths.basis);
        self.azimuths = azimuths;
    }

    /// Drops the rows that nothing uses any more.
    pub(super) fn prune(&mut self) {
        let mut elevations = Numbers::default();
        self.azimuths.index.iter_mut().for_each(|row| *row = elevations.of(*row));
        let mut pairs = Numbers::default();
        let mut kept = super::views::Rows::new(self.elevations.columns);
        kept.basis = std::mem::take(&mut self.elevations.basis);
        for row in &elevations.kept {
            let (index, scale) = self.elevations.row(*row);
            kept.index.extend(index.iter().map(|pair| pairs.of(*pair)));
            kept.scale.extend_from_slice(scale);
            kept.squares.push(self.elevations.squares[*row as usize]);
            kept.book.push(self.elevations.book.features(*row));
        }
        self.elevations = kept;
        self.slices.prune(&pairs.kept, &Limits::EXACT);
    }
}

/// New numbers in the order of first use.
#[derive(Default)]
struct Numbers {
    kept: Vec<u32>,
    places: HashMap<u32, u32>,
}

impl Numbers {
    fn of(&mut self, row: u32) -> u32 {
        let kept = &mut self.kept;
        *self.places.entry(row).or_insert_with(|| {
            kept.push(row);
            kept.len() as u32 - 1
        })
    }
}
