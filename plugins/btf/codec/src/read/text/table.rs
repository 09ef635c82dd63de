//! One table of numbers.

use std::path::{Path, PathBuf};

use super::text_of;
use crate::{BtfError, References, Samples, Scaled};

/// More numbers than this in one file are refused: 2^26.
const LIMIT: usize = 1 << 26;

/// A table of numbers under its header.
struct Table<T> {
    path: PathBuf,
    columns: usize,
    range: [T; 2],
    values: Vec<T>,
}

impl<T: std::str::FromStr + Copy> Table<T> {
    fn read(path: &Path) -> Result<Self, BtfError> {
        let text = text_of(path)?;
        let (header, body) = text.split_once('\n').unwrap_or((&text, ""));
        let wrong = |what: String| BtfError::format(path, what);
        let fields: Vec<&str> = header.split_whitespace().collect();
        let [rows, columns, min, max] = fields[..] else {
            return Err(wrong(format!("line 1 is {header:?}, not 'rows columns least greatest'")));
        };
        let count = |field: &str| {
            field.parse::<usize>().map_err(|_| wrong(format!("line 1: {field:?} is no count")))
        };
        let bound = |field: &str| {
            field.parse::<T>().map_err(|_| wrong(format!("line 1: {field:?} is no bound")))
        };
        let (rows, columns) = (count(rows)?, count(columns)?);
        let expected = rows.checked_mul(columns).filter(|count| *count <= LIMIT);
        let expected = expected.ok_or_else(|| {
            wrong(format!("line 1: {rows} rows of {columns} are more than {LIMIT} numbers"))
        })?;
        // The text bounds the memory, whatever the header says.
        let mut values = Vec::with_capacity(expected.min(body.len()));
        for (line, text) in body.lines().enumerate() {
            for word in text.split_whitespace() {
                values.push(word.parse().map_err(|_| {
                    wrong(format!("line {}: {word:?} is no number of this table", line + 2))
                })?);
            }
        }
        if values.len() != expected {
            return Err(wrong(format!(
                "{} numbers instead of {rows} rows of {columns}",
                values.len()
            )));
        }
        Ok(Self { path: path.to_owned(), columns, range: [bound(min)?, bound(max)?], values })
    }
}

pub(super) fn samples(path: &Path) -> Result<Samples, BtfError> {
    let table = Table::<f32>::read(path)?;
    Ok(Samples { columns: table.columns, value: table.values, range: Some(table.range) })
}

pub(super) fn references(path: &Path) -> Result<References, BtfError> {
    let table = Table::<u32>::read(path)?;
    Ok(References { columns: table.columns, index: table.values })
}

/// Indices, counted from `first`, and factors.
pub(super) fn scaled(indices: &Path, factors: &Path, first: u32) -> Result<Scaled, BtfError> {
    let indices = Table::<u32>::read(indices)?;
    let factors = Table::<f32>::read(factors)?;
    let (columns, other) = (indices.columns, factors.columns);
    if columns != other || indices.values.len() != factors.values.len() {
        return Err(BtfError::format(
            factors.path,
            format!("another shape than {}", indices.path.display()),
        ));
    }
    let mut index = indices.values;
    for (at, index) in index.iter_mut().enumerate() {
        *index = index.checked_sub(first).ok_or_else(|| {
            let place = format!("row {}, column {}", at / columns, at % columns);
            BtfError::format(&indices.path, format!("{place} has not been compressed yet"))
        })?;
    }
    Ok(Scaled { columns, index, scale: factors.values, range: Some(factors.range) })
}
