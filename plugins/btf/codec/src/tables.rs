//! The code-books of a material as plain vectors: what readers and the compressor make.

use crate::ColourSpace;

/// Rows of indices into another table, each with a factor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scaled {
    /// Entries in a row.
    pub columns: usize,
    /// Rows of the table below, 0-based, row after row.
    pub index: Vec<u32>,
    /// As many factors.
    pub scale: Vec<f32>,
    /// Least and greatest factor as the source declares them, if it does.
    pub range: Option<[f32; 2]>,
}

impl Scaled {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.index.len() / self.columns.max(1)
    }
}

/// Rows of indices into another table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct References {
    /// Entries in a row.
    pub columns: usize,
    /// Rows of the table below, 0-based, row after row.
    pub index: Vec<u32>,
}

impl References {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.index.len() / self.columns.max(1)
    }
}

/// Rows of numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Numbers in a row.
    pub columns: usize,
    /// Row after row.
    pub value: Vec<f32>,
    /// Least and greatest number as the source declares them, if it does.
    pub range: Option<[f32; 2]>,
}

impl Samples {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.value.len() / self.columns.max(1)
    }
}

/// All code-books of a material; the page of this crate says how they hang together.
#[derive(Clone, Debug, PartialEq)]
pub struct Tables {
    /// How the luminances and colours are meant.
    pub colour_space: ColourSpace,
    /// Whether the angle beta is sampled at equal steps of its sine (else at equal steps of itself).
    pub beta_uniform_in_sine: bool,
    /// One entry a texel, a row of the picture after the other, to `azimuths`.
    pub texels: Scaled,
    /// Entries round the view's azimuth, from 0 on in equal steps, to `elevations`.
    pub azimuths: Scaled,
    /// Entries over the view's elevation, from 0 to 90 degrees in equal steps, to `slices`.
    pub elevations: Scaled,
    /// Pairs of a row of `luminances` and a row of `chromas`.
    pub slices: References,
    /// Entries over alpha, from -90 to 90 degrees in equal steps, to `shapes`.
    pub luminances: Scaled,
    /// Luminances over beta, from -90 to 90 degrees, before their scale.
    pub shapes: Samples,
    /// Entries over alpha, to `colour_rows`.
    pub chromas: References,
    /// Entries over beta, to `colours`.
    pub colour_rows: References,
    /// Pairs of chroma: (Cb, Cr), neutral at 128, or 410 times (u', v').
    pub colours: Samples,
}
