//! A material ready for evaluation.

use crate::{BtfError, ColourSpace, Layout, Tables, pack};

/// What is known of a material besides its tables.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Info {
    /// Its name.
    pub name: String,
    /// What it was made from, and how.
    pub source: String,
    /// Width and height of the picture in metres, if known.
    pub size: Option<[f32; 2]>,
}

/// A compressed material: code-books packed into words, checked once, so that every evaluation
/// stays inside them.
#[derive(Clone, Debug)]
pub struct Btf {
    info: Info,
    layout: Layout,
    words: Vec<u32>,
}

impl Btf {
    /// Packs tables.
    ///
    /// Factors and luminances that lie on 256 steps between their least and their greatest, as
    /// those of the BTFbase format do, are kept exactly; others are rounded to as many steps as
    /// there is room for (2^12 and more).
    ///
    /// # Errors
    ///
    /// Tables that are empty, of unequal length, not finite, or refer to rows that do not exist.
    pub fn new(info: Info, columns: usize, tables: &Tables) -> Result<Self, BtfError> {
        let (layout, words) = pack::pack(columns, tables)?;
        Ok(Self { info, layout, words })
    }

    /// What is known of the material.
    pub fn info(&self) -> &Info {
        &self.info
    }

    /// Where the tables lie.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The tables.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        [self.layout.columns, self.layout.rows]
    }

    /// What the channels mean.
    pub fn colour_space(&self) -> ColourSpace {
        if self.layout.flags & Layout::LOG_LUV == 0 {
            ColourSpace::YCbCr
        } else {
            ColourSpace::LogLuv { factor: self.layout.factor }
        }
    }
}
