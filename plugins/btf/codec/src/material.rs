//! A material ready for evaluation.

use crate::check::{self, Rows};
use crate::words::Words;
use crate::{BtfError, ColourSpace, Info, Layout, Tables, pack};

/// A compressed material: code-books packed into words, checked once, so that every evaluation
/// stays inside them.
#[derive(Clone, Debug)]
pub struct Btf {
    info: Info,
    layout: Layout,
    rows: Rows,
    words: Words,
}

/// Place and size of a table, for reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TableSize {
    /// Its field in [`Layout`].
    pub name: &'static str,
    /// Rows, up to the last one that something refers to.
    pub rows: u32,
    /// Entries in a row.
    pub columns: u32,
    /// What the rows take among the words.
    pub bytes: u64,
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
        Self::from_parts(info, layout, Words::Owned(words))
    }

    /// Checks everything that evaluation relies on.
    pub(crate) fn from_parts(info: Info, layout: Layout, words: Words) -> Result<Self, BtfError> {
        let rows = check::check(&layout, words.as_slice())?;
        Ok(Self { info, layout, rows, words })
    }

    /// The same material under another description.
    #[must_use]
    pub fn with_info(self, info: Info) -> Self {
        Self { info, ..self }
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
        self.words.as_slice()
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

    /// The tables' sizes, in the order of a look-up.
    pub fn table_sizes(&self) -> [TableSize; 7] {
        let (layout, rows) = (&self.layout, &self.rows);
        let table = |name, rows: u32, columns: u32, stride: u32| TableSize {
            name,
            rows,
            columns,
            bytes: u64::from(rows) * u64::from(stride) * 4,
        };
        let (phi, theta) = (layout.phi_count, layout.theta_count);
        let (alpha, beta) = (layout.alpha_count, layout.beta_count);
        [
            table("texels", layout.rows, layout.columns, layout.columns),
            table("azimuths", rows.azimuths, phi, phi),
            table("elevations", rows.elevations, theta, 2 * theta),
            table("luminances", rows.luminances, alpha, alpha),
            table("shapes", rows.shapes, beta, layout.shapes.stride),
            table("chromas", rows.chromas, alpha, alpha),
            table("colour rows", rows.colour_rows, beta, layout.colour_rows.stride),
        ]
    }
}
