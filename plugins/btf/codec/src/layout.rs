//! Where the tables of a material lie among its words: the same struct in files, on the CPU and in
//! the shaders (`shaders/btf/layout.wgsl`).

use bytemuck::{Pod, Zeroable};

/// A table of indices with factors, one word an entry: the index in the low `index_bits` bits, the
/// code of the factor above it; factor = `min + code * step`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Packed {
    /// First word.
    pub offset: u32,
    /// Bits of the index, 1 to 31.
    pub index_bits: u32,
    /// Factor of code 0.
    pub min: f32,
    /// Difference of two neighbouring codes.
    pub step: f32,
}

/// Numbers as 16-bit codes, two a word, the first in the low half; a row begins on a word.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Coded {
    /// First word.
    pub offset: u32,
    /// Words from one row to the next.
    pub stride: u32,
    /// Number of code 0.
    pub min: f32,
    /// Difference of two neighbouring codes.
    pub step: f32,
}

/// Sizes and places of all tables. Offsets count words from the first word of the material, or,
/// after [`Layout::moved`], of a buffer that holds several.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Layout {
    /// Texels in a row.
    pub columns: u32,
    /// Rows of texels.
    pub rows: u32,
    /// [`Layout::LOG_LUV`], [`Layout::BETA_IN_SINE`].
    pub flags: u32,
    /// Words of all tables.
    pub words: u32,
    /// Samples of the view's azimuth.
    pub phi_count: u32,
    /// Samples of the view's elevation.
    pub theta_count: u32,
    /// Samples of alpha.
    pub alpha_count: u32,
    /// Samples of beta.
    pub beta_count: u32,
    /// To azimuths; one entry a texel.
    pub texels: Packed,
    /// To elevations; `phi_count` entries a row.
    pub azimuths: Packed,
    /// To luminances; `theta_count` entries a row, each followed by a word of its own with the row
    /// of chromas: the table of slices is dissolved in this one.
    pub elevations: Packed,
    /// To shapes; `alpha_count` entries a row.
    pub luminances: Packed,
    /// Luminances: `beta_count` codes a row.
    pub shapes: Coded,
    /// Chromas: `beta_count` words a row, the first chroma in the low half, the second in the high
    /// half; the table of colours is dissolved in this one.
    pub colour_rows: Coded,
    /// First word of the chromas: `alpha_count` words a row, each a row of colour rows.
    pub chromas: u32,
    /// What a colour of [`Layout::LOG_LUV`] is divided by.
    pub factor: f32,
    /// Zero.
    pub reserved: [u32; 2],
}

impl Layout {
    /// Flag: logarithmic luma with u' and v'; else video luma and chroma.
    pub const LOG_LUV: u32 = 1;
    /// Flag: samples of beta at equal steps of its sine.
    pub const BETA_IN_SINE: u32 = 2;

    /// The layout in a buffer where the material begins at word `base`.
    pub fn moved(mut self, base: u32) -> Self {
        for offset in [
            &mut self.texels.offset,
            &mut self.azimuths.offset,
            &mut self.elevations.offset,
            &mut self.luminances.offset,
            &mut self.shapes.offset,
            &mut self.colour_rows.offset,
            &mut self.chromas,
        ] {
            *offset += base;
        }
        self
    }
}
