//! Compression by multi-level vector quantization.
//!
//! After Havran, Filip and Myszkowski 2010 (the page of this crate shows the levels): code-books
//! grow while the texels go by. What a texel looks like from one azimuth, from one direction, along
//! one arc of lights is compared with the rows that are there already, whatever their brightness;
//! a row that is near enough is used again with a scale, else a row is added. Before the second and
//! later passes rows move into the middle of what they stand for.
//!
//! Rows are found by a few coordinates on the directions along which the material varies most;
//! distances of these never exceed those of the rows, and the best few are compared in full.

mod basis;
mod books;
mod grid;
mod refine;
mod slices;
mod views;

use std::ops::{ControlFlow, Range};

use rayon::prelude::*;

use crate::{Btf, BtfError, Info, Tables};
use books::{Books, Texel};
use refine::Centres;

pub use grid::Grid;

/// Samples of a texel, at most.
const MOST_SAMPLES: usize = 1 << 20;
/// Texels that are looked up side by side before any of them changes the books. It decides what
/// comes out, so it depends on nothing but the grid.
fn batch(grid: &Grid) -> usize {
    ((1 << 20) / grid.samples().max(1)).clamp(1, 64)
}

/// A material to be compressed.
pub trait TexelSource: Sync {
    /// Width and height in texels.
    fn size(&self) -> [u32; 2];

    /// At which directions a texel is sampled.
    fn grid(&self) -> Grid;

    /// How many rows of texels should be loaded at once.
    fn band(&self) -> u32 {
        self.size()[1]
    }

    /// Called before texels of these rows are asked for, again for each pass.
    ///
    /// # Errors
    ///
    /// What can't be read.
    fn load(&mut self, rows: Range<u32>) -> Result<(), BtfError> {
        let _ = rows;
        Ok(())
    }

    /// Samples of a texel in the order of [`Grid::index`]: red, green and blue, gamma-encoded, 255
    /// for white, with the cosine of the light in it. Negative ones count as 0.
    fn texel(&self, x: u32, y: u32, samples: &mut [[f32; 3]]);
}

/// How well to compress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quality {
    /// The root mean square error that a texel may have over its samples, in 1 of 255.
    Error(f32),
    /// Bytes of the packed tables; the error is found by trying.
    Bytes(usize),
}

/// How to compress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Size or error.
    pub quality: Quality,
    /// How often the texels go by, 1 to 8.
    pub passes: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { quality: Quality::Error(6.0), passes: 2 }
    }
}

/// What became of the material. Errors are in 1 of 255 of the gamma-encoded value, at the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// The error that was asked for or found by trying.
    pub limit: f32,
    /// Root mean square over all texels, samples and channels.
    pub error: f32,
    /// Root mean square of the texel that has the largest.
    pub worst_texel: f32,
    /// Largest difference of a channel.
    pub largest: f32,
    /// Bytes of the packed tables.
    pub bytes: usize,
    /// Bytes of the samples at one byte a channel.
    pub original: usize,
}

impl Report {
    /// Peak signal-to-noise ratio in decibels.
    pub fn psnr(&self) -> f32 {
        20.0 * (255.0 / self.error).log10()
    }

    /// How much smaller the tables are than the samples.
    pub fn ratio(&self) -> f32 {
        self.original as f32 / self.bytes as f32
    }
}

/// A compressed material.
#[derive(Clone, Debug)]
pub struct Compressed {
    /// Texels in a row.
    pub columns: usize,
    /// The code-books.
    pub tables: Tables,
    /// What became of it.
    pub report: Report,
}

impl Compressed {
    /// Packs the tables.
    ///
    /// # Errors
    ///
    /// As [`Btf::new`].
    pub fn into_btf(self, info: Info) -> Result<Btf, BtfError> {
        Btf::new(info, self.columns, &self.tables)
    }
}

/// Root mean square errors that rows of the levels may have.
#[derive(Clone, Copy, Debug)]
struct Limits {
    total: f32,
    luminance: f32,
    chroma: f32,
    shape: f32,
    colours: f32,
    colour_step: f32,
}

impl Limits {
    /// Rows that stay what they are.
    const EXACT: Self = Self {
        total: 0.0,
        luminance: 0.0,
        chroma: 0.0,
        shape: 1e-3,
        colours: 1e-3,
        colour_step: 1.0 / 64.0,
    };

    fn new(error: f32) -> Self {
        Self {
            total: error,
            luminance: 0.85 * error,
            chroma: 0.4 * error,
            shape: 0.6 * error,
            colours: 0.3 * error,
            colour_step: (0.1 * error).max(0.25),
        }
    }

    /// For a row that is going to be used with a scale.
    fn tightened(mut self, scale: f32) -> Self {
        self.shape /= scale.max(1.0);
        self.colours /= scale.max(1.0);
        self
    }
}

/// Compresses a material.
///
/// `progress` hears how much is done, 0 to 1, and can stop it: then the answer is `None`. The
/// result depends on source and settings alone, not on the number of threads. Memory: a batch of
/// at most 2^20 samples and the code-books, about 2 kB a row of elevations.
///
/// # Errors
///
/// What the source says, samples that are not finite, settings or grids out of range.
pub fn compress(
    source: &mut dyn TexelSource,
    settings: &Settings,
    progress: &mut dyn FnMut(f32) -> ControlFlow<()>,
) -> Result<Option<Compressed>, BtfError> {
    let grid = source.grid();
    let [columns, rows] = source.size();
    let sides = [grid.phi, grid.theta, grid.alpha, grid.beta];
    let enough =
        sides.iter().zip([1, 2, 2, 2]).all(|(count, least)| (least..=1024).contains(count));
    if !enough || sides.iter().product::<usize>() > MOST_SAMPLES {
        return Err(BtfError::Unsupported(format!("a grid of {sides:?} directions")));
    }
    if columns == 0 || rows == 0 || !(1..=8).contains(&settings.passes) {
        return Err(BtfError::Unsupported(format!(
            "{columns} x {rows} texels in {} passes",
            settings.passes
        )));
    }
    match settings.quality {
        Quality::Error(error) if error > 0.0 && error.is_finite() => {
            let mut run = Run { source, passes: settings.passes, most: usize::MAX, progress };
            run.run(error)
        }
        Quality::Error(error) => Err(BtfError::Unsupported(format!("an error of {error}"))),
        Quality::Bytes(bytes) => search(source, settings.passes, bytes, progress),
    }
}

/// How many errors are tried for a size.
const TRIES: u32 = 7;

/// The smallest error, near enough, that a number of bytes is sufficient for.
fn search(
    source: &mut dyn TexelSource,
    passes: u32,
    bytes: usize,
    progress: &mut dyn FnMut(f32) -> ControlFlow<()>,
) -> Result<Option<Compressed>, BtfError> {
    let (mut low, mut high) = (0.5_f32, 64.0_f32);
    let mut best = None;
    for attempt in 0..TRIES {
        let error = (low * high).sqrt();
        let mut stopped = false;
        let mut part = |done: f32| {
            let flow = progress((attempt as f32 + done) / TRIES as f32);
            stopped = flow.is_break();
            flow
        };
        let found = Run { source, passes, most: bytes, progress: &mut part }.run(error)?;
        if stopped {
            return Ok(None);
        }
        match found {
            Some(found) => {
                high = error;
                best = Some(found);
            }
            None => low = error,
        }
    }
    let too_small =
        || BtfError::Unsupported(format!("{bytes} bytes are too few for this material"));
    best.map(Some).ok_or_else(too_small)
}

struct Run<'a> {
    source: &'a mut dyn TexelSource,
    passes: u32,
    /// Gives up beyond so many bytes.
    most: usize,
    progress: &'a mut dyn FnMut(f32) -> ControlFlow<()>,
}

impl Run<'_> {
    /// `None` if it was stopped or became too large.
    fn run(&mut self, error: f32) -> Result<Option<Compressed>, BtfError> {
        let limits = Limits::new(error);
        let grid = self.source.grid();
        let [columns, rows] = self.source.size();
        let mut books = Books::new(grid);
        let mut report = Report::default();
        for pass in 0..self.passes {
            let last = pass + 1 == self.passes;
            let mut centres = (!last).then(Centres::new);
            let Some(found) = self.pass(&mut books, &limits, pass, centres.as_mut())? else {
                return Ok(None);
            };
            report = found;
            if let Some(centres) = centres {
                centres.apply(&mut books, &limits);
            }
            books.prune();
            if !last {
                books.forget_texels();
            }
        }
        let texels = columns as usize * rows as usize;
        report.limit = error;
        report.bytes = books.bytes();
        report.original = texels * grid.samples() * 3;
        if report.bytes > self.most {
            return Ok(None);
        }
        Ok(Some(Compressed { columns: columns as usize, tables: books.into_tables(), report }))
    }

    /// All texels once.
    fn pass(
        &mut self,
        books: &mut Books,
        limits: &Limits,
        pass: u32,
        mut centres: Option<&mut Centres>,
    ) -> Result<Option<Report>, BtfError> {
        let grid = *books.grid();
        let [columns, rows] = self.source.size();
        let (mut squares, mut worst, mut largest) = (0.0_f64, 0.0_f32, 0.0_f32);
        let values = 3 * grid.samples();
        let band = self.source.band().clamp(1, rows);
        for first in (0..rows).step_by(band as usize) {
            let range = first..(first + band).min(rows);
            self.source.load(range.clone())?;
            let source = &*self.source;
            let read = |at: u64| {
                let mut samples = vec![[0.0; 3]; grid.samples()];
                source.texel(
                    (at % u64::from(columns)) as u32,
                    (at / u64::from(columns)) as u32,
                    &mut samples,
                );
                Texel::new(&grid, &samples)
            };
            let texels = u64::from(range.start) * u64::from(columns)
                ..u64::from(range.end) * u64::from(columns);
            if pass == 0 && first == 0 {
                let count = (texels.end - texels.start).div_ceil(48).max(1);
                let some: Vec<_> = texels.clone().step_by(count as usize).collect();
                let some: Result<Vec<_>, _> = some.into_par_iter().map(read).collect();
                books.learn(&some?);
            }
            let all: Vec<u64> = texels.collect();
            for batch in all.chunks(batch(&grid)) {
                let before = books.before();

                let plans: Result<Vec<_>, BtfError> = batch
                    .par_iter()
                    .map(|at| {
                        let texel = read(*at)?;
                        let plan = books.plan(&texel, limits);
                        Ok((texel, plan))
                    })
                    .collect();
                let mut done = Vec::with_capacity(batch.len());
                for (texel, plan) in plans? {
                    books.commit(&texel, plan, before, limits);
                    let row = books.texels[books.texels.len() - 1];
                    if let Some(centres) = &mut centres {
                        centres.add(books, &texel, row);
                    }
                    done.push((texel, row));
                }
                books.check()?;
                let errors: Vec<_> =
                    done.par_iter().map(|(texel, row)| books.errors(texel, *row)).collect();
                for (square, most) in errors {
                    squares += f64::from(square);
                    worst = worst.max(square);
                    largest = largest.max(most);
                }
                let share =
                    books.texels.len() as f32 / (f64::from(columns) * f64::from(rows)) as f32;
                let flow = (self.progress)((pass as f32 + share) / self.passes as f32);
                // Pruning can make it a little smaller.
                let too_large = books.bytes() / 4 * 3 > self.most;
                if flow.is_break() || too_large {
                    return Ok(None);
                }
            }
        }
        let count = values as f64 * books.texels.len() as f64;
        Ok(Some(Report {
            error: (squares / count).sqrt() as f32,
            worst_texel: (worst / values as f32).sqrt(),
            largest,
            ..Report::default()
        }))
    }
}
