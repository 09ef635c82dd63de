//! Measured pictures at the directions of a grid, as the compressor wants them.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use super::{ImageBtf, LINEAR, Picture, encode};
use crate::BtfError;
use crate::compress::{Grid, TexelSource};

/// Bytes of texels that are held at once.
const BAND_BYTES: u64 = 512 << 20;
/// Pictures that are decoded side by side.
const GROUP: usize = 32;

/// The texels of measured pictures, interpolated to the directions of a [`Grid`]; see [`ImageBtf`] for
/// how. At most 512 MiB of texels are in memory, but one row at least; pictures are read again for
/// each band of rows.
pub struct Resampled<'a> {
    images: &'a ImageBtf,
    grid: Grid,
    /// Where the contributions of each sample begin, and the end.
    begin: Vec<u32>,
    contributions: Vec<(u32, f32)>,
    rows: Range<u32>,
    /// All pictures' values of a texel, then those of the next texel.
    texels: Vec<[u8; 3]>,
}

impl<'a> Resampled<'a> {
    /// Nothing is read before it is asked for.
    pub fn new(images: &'a ImageBtf, grid: Grid) -> Self {
        let mut begin = vec![0];
        let mut contributions = Vec::new();
        for phi in 0..grid.phi {
            for theta in 0..grid.theta {
                for alpha in 0..grid.alpha {
                    for beta in 0..grid.beta {
                        let angles = grid.angles(phi, theta, alpha, beta);
                        contributions.extend(images.contributions(angles));
                        begin.push(contributions.len() as u32);
                    }
                }
            }
        }
        Self { images, grid, begin, contributions, rows: 0..0, texels: Vec::new() }
    }
}

impl TexelSource for Resampled<'_> {
    fn size(&self) -> [u32; 2] {
        self.images.size()
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn band(&self) -> u32 {
        let [columns, rows] = self.size();
        let row = 3 * u64::from(columns) * self.images.pictures() as u64;
        (BAND_BYTES / row.max(1)).clamp(1, u64::from(rows)) as u32
    }

    fn load(&mut self, rows: Range<u32>) -> Result<(), BtfError> {
        if rows == self.rows {
            return Ok(());
        }
        // What is here is no longer whole.
        self.rows = 0..0;
        let columns = self.size()[0] as usize;
        let first = rows.start as usize * columns;
        let pictures = self.images.pictures();
        self.texels.clear();
        self.texels.resize(rows.len() * columns * pictures, [0; 3]);
        for from in (0..pictures).step_by(GROUP) {
            let group: Vec<Picture> = (from..(from + GROUP).min(pictures))
                .into_par_iter()
                .map(|number| self.images.picture(number as u32))
                .collect::<Result<_, _>>()?;
            self.texels.par_chunks_exact_mut(pictures).enumerate().for_each(|(texel, values)| {
                for (value, picture) in values[from..].iter_mut().zip(&group) {
                    *value = picture.texels[first + texel];
                }
            });
        }
        self.rows = rows;
        Ok(())
    }

    fn texel(&self, x: u32, y: u32, samples: &mut [[f32; 3]]) {
        let pictures = self.images.pictures();
        let row = y.saturating_sub(self.rows.start) as usize;
        let texel = row * self.size()[0] as usize + x as usize;
        let Some(values) = self.texels.chunks_exact(pictures).nth(texel) else { return };
        let light: Vec<Vec3> = values
            .iter()
            .map(|value| value.map(|channel| LINEAR[channel as usize]).into())
            .collect();
        for (sample, range) in samples.iter_mut().zip(self.begin.windows(2)) {
            let parts = &self.contributions[range[0] as usize..range[1] as usize];
            let sum: Vec3 =
                parts.iter().map(|(picture, weight)| *weight * light[*picture as usize]).sum();
            *sample = encode(sum).into();
        }
    }
}
