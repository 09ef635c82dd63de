//! The proof that no look-up leaves the words of a material, whoever wrote them.

use crate::layout::{Coded, Layout, Packed};
use crate::{BtfError, pack};

/// Rows of the tables that a look-up can reach: one more than the greatest index that leads there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Rows {
    pub(crate) azimuths: u32,
    pub(crate) elevations: u32,
    pub(crate) luminances: u32,
    pub(crate) shapes: u32,
    pub(crate) chromas: u32,
    pub(crate) colour_rows: u32,
}

type Result<T> = std::result::Result<T, BtfError>;

fn damaged(what: impl Into<String>) -> BtfError {
    BtfError::Tables(what.into())
}

/// Follows every index of `layout` and `words`, from the texels down.
pub(crate) fn check(layout: &Layout, words: &[u32]) -> Result<Rows> {
    if layout.words as usize != words.len() {
        return Err(damaged(format!("{} words instead of {}", words.len(), layout.words)));
    }
    if layout.flags & !(Layout::LOG_LUV | Layout::BETA_IN_SINE) != 0 || layout.reserved != [0; 2] {
        return Err(damaged("unknown flags"));
    }
    if !(layout.factor.is_finite() && layout.factor > 0.0) {
        return Err(damaged(format!("the HDR factor is {}", layout.factor)));
    }
    if layout.columns == 0 || layout.rows == 0 {
        return Err(damaged(format!("{} columns and {} rows", layout.columns, layout.rows)));
    }
    let Layout { phi_count, theta_count, alpha_count, beta_count, .. } = *layout;
    for (name, count, least) in [
        ("azimuths", phi_count, 1),
        ("elevations", theta_count, 2),
        ("alpha samples", alpha_count, 2),
        ("beta samples", beta_count, 2),
    ] {
        pack::sample_count(name, count as usize, least)?;
    }
    let mut tables = Walk { words, from: 0 };
    let texels = tables.packed("texels", &layout.texels, layout.rows, layout.columns)?;
    let azimuths = rows_below(&layout.texels, texels.iter());
    let entries = tables.packed("azimuths", &layout.azimuths, azimuths, phi_count)?;
    let elevations = rows_below(&layout.azimuths, entries.iter());
    let entries = tables.packed("elevations", &layout.elevations, elevations, 2 * theta_count)?;
    let luminances = rows_below(&layout.elevations, entries.iter().step_by(2));
    let chromas = highest(entries.iter().skip(1).step_by(2).copied());
    let entries = tables.packed("luminances", &layout.luminances, luminances, alpha_count)?;
    let shapes = rows_below(&layout.luminances, entries.iter());
    tables.coded("shapes", &layout.shapes, shapes, beta_count.div_ceil(2))?;
    let entries = tables.table("chromas", layout.chromas, chromas, alpha_count)?;
    let colour_rows = highest(entries.iter().copied());
    tables.coded("colour rows", &layout.colour_rows, colour_rows, beta_count)?;
    Ok(Rows { azimuths, elevations, luminances, shapes, chromas, colour_rows })
}

/// The rows that the indices of a table need.
fn rows_below<'a>(table: &Packed, entries: impl Iterator<Item = &'a u32>) -> u32 {
    let mask = (1 << table.index_bits) - 1;
    highest(entries.map(|word| word & mask))
}

/// The rows that indices need.
fn highest(indices: impl Iterator<Item = u32>) -> u32 {
    indices.max().map_or(0, |row| row.saturating_add(1))
}

/// Goes through tables that lie one after the other.
struct Walk<'a> {
    words: &'a [u32],
    /// Where the last table ends.
    from: u64,
}

impl<'a> Walk<'a> {
    /// A table's words. One word must follow the last table: look-ups may read two at once.
    fn table(&mut self, name: &str, offset: u32, rows: u32, stride: u32) -> Result<&'a [u32]> {
        let end = u64::from(offset) + u64::from(rows) * u64::from(stride);
        if u64::from(offset) < self.from || end >= self.words.len() as u64 {
            return Err(damaged(format!(
                "the {name} reach from word {offset} to {end}, between {} and {}: {rows} rows of \
                 {stride}",
                self.from,
                self.words.len()
            )));
        }
        self.from = end;
        Ok(&self.words[offset as usize..end as usize])
    }

    fn packed(&mut self, name: &str, table: &Packed, rows: u32, columns: u32) -> Result<&'a [u32]> {
        let bits = table.index_bits;
        if !(1..=31).contains(&bits) {
            return Err(damaged(format!("{bits} bits an index in the {name}")));
        }
        finite(name, table.min, table.step, u32::MAX >> bits)?;
        self.table(name, table.offset, rows, columns)
    }

    /// `row` is what a row needs, in words.
    fn coded(&mut self, name: &str, table: &Coded, rows: u32, row: u32) -> Result<()> {
        if table.stride < row {
            return Err(damaged(format!("rows of the {name} overlap")));
        }
        finite(name, table.min, table.step, 0xffff)?;
        self.table(name, table.offset, rows, table.stride).map(|_| ())
    }
}

/// Whether every code gives a finite number.
fn finite(name: &str, min: f32, step: f32, last: u32) -> Result<()> {
    if min.is_finite() && (min + last as f32 * step).is_finite() {
        Ok(())
    } else {
        Err(damaged(format!("codes of the {name} from {min} in steps of {step}")))
    }
}
