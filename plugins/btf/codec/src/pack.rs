//! Code-books into words, and the checks that make every later look-up safe.

use crate::layout::{Coded, Layout, Packed};
use crate::{BtfError, ColourSpace, References, Samples, Scaled, Tables};

/// More texels, samples or rows than this are refused: 2^26.
const LIMIT: usize = 1 << 26;

/// The most rows of a table that others refer to with a factor, so that a word has room for both.
const MOST_ROWS: usize = 1 << 20;

type Result<T> = std::result::Result<T, BtfError>;

fn damaged(what: impl Into<String>) -> BtfError {
    BtfError::Tables(what.into())
}

/// Layout and words of `tables`, whose picture has `columns` texels in a row.
pub(crate) fn pack(columns: usize, tables: &Tables) -> Result<(Layout, Vec<u32>)> {
    let texels = tables.texels.index.len();
    if columns == 0 || !texels.is_multiple_of(columns) {
        return Err(damaged(format!("{texels} texels do not make rows of {columns}")));
    }
    let counts = [
        ("azimuths", tables.azimuths.columns, 1),
        ("elevations", tables.elevations.columns, 2),
        ("alpha samples", tables.luminances.columns, 2),
        ("beta samples", tables.shapes.columns, 2),
    ];
    for (name, count, least) in counts {
        sample_count(name, count, least)?;
    }
    let same = [
        ("chromas", tables.chromas.columns, tables.luminances.columns),
        ("colour rows", tables.colour_rows.columns, tables.shapes.columns),
        ("slices", tables.slices.columns, 2),
        ("colours", tables.colours.columns, 2),
    ];
    for (name, count, expected) in same {
        if count != expected {
            return Err(damaged(format!("{name} have {count} columns instead of {expected}")));
        }
    }

    let mut words = Words::default();
    let mut layout = Layout {
        columns: columns as u32,
        rows: (texels / columns) as u32,
        phi_count: tables.azimuths.columns as u32,
        theta_count: tables.elevations.columns as u32,
        alpha_count: tables.luminances.columns as u32,
        beta_count: tables.shapes.columns as u32,
        factor: 1.0,
        ..Layout::default()
    };
    if let ColourSpace::LogLuv { factor } = tables.colour_space {
        if !(factor.is_finite() && factor > 0.0) {
            return Err(damaged(format!("the HDR factor is {factor}")));
        }
        layout.flags |= Layout::LOG_LUV;
        layout.factor = factor;
    }
    if tables.beta_uniform_in_sine {
        layout.flags |= Layout::BETA_IN_SINE;
    }
    // From what is read first in an evaluation to what is read last.
    layout.texels = words.scaled("texels", &tables.texels, tables.azimuths.rows())?;
    layout.azimuths = words.scaled("azimuths", &tables.azimuths, tables.elevations.rows())?;
    layout.elevations = words.elevations(tables)?;
    layout.luminances = words.scaled("luminances", &tables.luminances, tables.shapes.rows())?;
    layout.shapes = words.coded("shapes", &tables.shapes)?;
    layout.chromas = words.references("chromas", &tables.chromas, tables.colour_rows.rows())?;
    layout.colour_rows = words.colour_rows(tables)?;
    // A look-up may read one word beyond the last row.
    words.0.push(0);
    layout.words = words.0.len() as u32;
    Ok((layout, words.0))
}

/// Fails where there are too few or too many samples along an axis.
pub(crate) fn sample_count(name: &str, count: usize, least: usize) -> Result<()> {
    if (least..=1024).contains(&count) {
        Ok(())
    } else {
        Err(damaged(format!("{count} {name}; {least} to 1024 are possible")))
    }
}

#[derive(Default)]
struct Words(Vec<u32>);

impl Words {
    /// The next word's place; tables begin on whole cache lines of the GPU.
    fn start(&mut self) -> u32 {
        self.0.resize(self.0.len().next_multiple_of(16), 0);
        self.0.len() as u32
    }

    fn scaled(&mut self, name: &str, table: &Scaled, below: usize) -> Result<Packed> {
        whole_rows(name, table.columns, table.index.len())?;
        in_range(name, &table.index, below)?;
        if table.scale.len() != table.index.len() {
            return Err(damaged(format!(
                "{name} have {} indices and {} factors",
                table.index.len(),
                table.scale.len()
            )));
        }
        if below > MOST_ROWS {
            return Err(damaged(format!(
                "the {name} lead to {below} rows; {MOST_ROWS} are possible"
            )));
        }
        let index_bits = bits(below).max(1);
        let steps = Steps::of(name, &table.scale, table.range, 32 - index_bits)?;
        let offset = self.start();
        self.0.extend(
            table
                .index
                .iter()
                .zip(&table.scale)
                .map(|(index, scale)| index | steps.code(*scale) << index_bits),
        );
        Ok(Packed { offset, index_bits, min: steps.min, step: steps.step })
    }

    fn coded(&mut self, name: &str, table: &Samples) -> Result<Coded> {
        whole_rows(name, table.columns, table.value.len())?;
        let steps = Steps::of(name, &table.value, table.range, 16)?;
        let offset = self.start();
        for row in table.value.chunks_exact(table.columns) {
            self.halves(row.iter().map(|value| steps.code(*value)));
        }
        let stride = table.columns.div_ceil(2) as u32;
        Ok(Coded { offset, stride, min: steps.min, step: steps.step })
    }

    /// Codes of 16 bits, two a word, the last word filled up.
    fn halves(&mut self, mut codes: impl Iterator<Item = u32>) {
        while let Some(low) = codes.next() {
            self.0.push(low | codes.next().unwrap_or(low) << 16);
        }
    }

    fn references(&mut self, name: &str, table: &References, below: usize) -> Result<u32> {
        whole_rows(name, table.columns, table.index.len())?;
        in_range(name, &table.index, below)?;
        let offset = self.start();
        self.0.extend(&table.index);
        Ok(offset)
    }

    /// Each entry leads to both halves of its slice at once.
    fn elevations(&mut self, tables: &Tables) -> Result<Packed> {
        let slices = tables.slices.index.as_chunks().0;
        whole_rows("slices", 2, tables.slices.index.len())?;
        in_range("elevations", &tables.elevations.index, slices.len())?;
        for (slice, [luminance, chroma]) in slices.iter().enumerate() {
            if *luminance as usize >= tables.luminances.rows()
                || *chroma as usize >= tables.chromas.rows()
            {
                return Err(damaged(format!(
                    "slice {slice} refers to row {luminance} of {} luminances and row {chroma} of {} chromas",
                    tables.luminances.rows(),
                    tables.chromas.rows()
                )));
            }
        }
        let slice = |index: &u32| slices[*index as usize];
        let luminances = Scaled {
            index: tables.elevations.index.iter().map(|index| slice(index)[0]).collect(),
            ..tables.elevations.clone()
        };
        let packed = self.scaled("elevations", &luminances, tables.luminances.rows())?;
        let first = self.0.split_off(packed.offset as usize);
        let chromas = tables.elevations.index.iter().map(|index| slice(index)[1]);
        self.0.extend(first.into_iter().zip(chromas).flat_map(|(first, second)| [first, second]));
        Ok(packed)
    }

    /// Colours in the place of their numbers.
    fn colour_rows(&mut self, tables: &Tables) -> Result<Coded> {
        let (rows, colours) = (&tables.colour_rows, &tables.colours);
        whole_rows("colours", 2, colours.value.len())?;
        whole_rows("colour rows", rows.columns, rows.index.len())?;
        in_range("colour rows", &rows.index, colours.rows())?;
        let steps = Steps::of("colours", &colours.value, colours.range, 16)?;
        let colours: Vec<u32> = (colours.value.as_chunks().0.iter())
            .map(|[first, second]| steps.code(*first) | steps.code(*second) << 16)
            .collect();
        let offset = self.start();
        self.0.extend(rows.index.iter().map(|colour| colours[*colour as usize]));
        Ok(Coded { offset, stride: rows.columns as u32, min: steps.min, step: steps.step })
    }
}

fn whole_rows(name: &str, columns: usize, length: usize) -> Result<()> {
    if length == 0 || columns == 0 || length > LIMIT || !length.is_multiple_of(columns) {
        return Err(damaged(format!("{name}: {length} entries in rows of {columns}")));
    }
    Ok(())
}

fn in_range(name: &str, indices: &[u32], below: usize) -> Result<()> {
    match indices.iter().position(|index| *index as usize >= below) {
        None => Ok(()),
        Some(at) => Err(damaged(format!(
            "entry {at} of the {name} refers to row {} of {below}",
            indices[at]
        ))),
    }
}

/// Bits of the numbers below `count`.
fn bits(count: usize) -> u32 {
    usize::BITS - count.saturating_sub(1).leading_zeros()
}

/// Equal steps between the least and the greatest of some numbers.
struct Steps {
    min: f32,
    step: f32,
    last: u32,
}

impl Steps {
    /// For `values`, in at most `bits` bits; `range` is what the source says of them.
    fn of(name: &str, values: &[f32], range: Option<[f32; 2]>, bits: u32) -> Result<Self> {
        let mut min = f32::INFINITY;
        let mut max = f32::NEG_INFINITY;
        for value in values {
            if !value.is_finite() {
                return Err(damaged(format!("a number among the {name} is not finite")));
            }
            min = min.min(*value);
            max = max.max(*value);
        }
        // BTFbase rounds to 256 steps; printed with six digits or so, they are still recognized.
        for [min, max] in range.into_iter().chain([[min, max]]) {
            let coarse = Self { min, step: (max - min) / 256.0, last: 256 };
            let tolerance = 2e-6 * min.abs().max(max.abs());
            let fits = |value: &f32| (coarse.value(coarse.code(*value)) - value).abs() <= tolerance;
            if coarse.step.is_finite() && values.iter().all(fits) {
                return Ok(coarse);
            }
        }
        let last = (1 << bits.min(20)) - 1;
        Ok(Self { min, step: (max - min) / last as f32, last })
    }

    fn code(&self, value: f32) -> u32 {
        if self.step > 0.0 {
            (((value - self.min) / self.step).round() as u32).min(self.last)
        } else {
            0
        }
    }

    fn value(&self, code: u32) -> f32 {
        self.min + code as f32 * self.step
    }
}
