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

/// Luminances, two 16-bit codes a word, the first in the low half; a row begins on a word.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Coded {
    /// First word.
    pub offset: u32,
    /// Words from one row to the next.
    pub stride: u32,
    /// Luminance of code 0.
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
    /// To slices; `theta_count` entries a row.
    pub elevations: Packed,
    /// To shapes; `alpha_count` entries a row.
    pub luminances: Packed,
    /// `beta_count` codes a row.
    pub shapes: Coded,
    /// First word of the slices: pairs of a row of luminances and a row of chromas.
    pub slices: u32,
    /// First word of the chromas: `alpha_count` words a row, each a row of colour rows.
    pub chromas: u32,
    /// First word of the colour rows: `beta_count` 16-bit colour numbers, two a word.
    pub colour_rows: u32,
    /// Words from one colour row to the next.
    pub colour_row_stride: u32,
    /// First word of the colours: pairs of 32-bit floats.
    pub colours: u32,
    /// Number of colours.
    pub colour_count: u32,
    /// What a colour of [`Layout::LOG_LUV`] is divided by.
    pub factor: f32,
    /// Zero.
    pub reserved: u32,
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
            &mut self.slices,
            &mut self.chromas,
            &mut self.colour_rows,
            &mut self.colours,
        ] {
            *offset += base;
        }
        self
    }
}
