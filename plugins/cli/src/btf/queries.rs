//! Lists of queries: a CSV file that is read piece by piece.

use std::{
    cell::Cell,
    fs::File,
    io::{self, Read},
    path::{Path, PathBuf},
    rc::Rc,
};

use csv::ByteRecord;

use crate::error::CliError;

/// The columns of a query.
pub(super) const COLUMNS: [&str; 6] = ["x", "y", "theta_i", "phi_i", "theta_v", "phi_v"];
/// The longest row.
const LONGEST_ROW: u64 = 1 << 20;

/// A texel and directions, in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Asked {
    pub(super) x: i64,
    pub(super) y: i64,
    /// theta_i, phi_i, theta_v, phi_v.
    pub(super) degrees: [f64; 4],
}

/// A query, and its six fields as they stand in the file.
pub(super) struct Row {
    pub(super) asked: Asked,
    pub(super) fields: ByteRecord,
}

/// The file.
pub(super) struct Queries<R> {
    path: PathBuf,
    reader: csv::Reader<Bounded<R>>,
    /// Where the columns of [`COLUMNS`] are.
    columns: [usize; 6],
    record: ByteRecord,
    row_began: Rc<Cell<u64>>,
}

impl Queries<File> {
    /// Opens the file and reads its header.
    pub(super) fn open(path: &Path) -> Result<Self, CliError> {
        let file = File::open(path).map_err(|error| CliError::io(path, "read", &error))?;
        Self::new(path, file)
    }
}

impl<R: Read> Queries<R> {
    fn new(path: &Path, source: R) -> Result<Self, CliError> {
        let row_began = Rc::new(Cell::new(0));
        let bounded = Bounded { source, given: 0, row_began: row_began.clone() };
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(bounded);
        let header = reader.byte_headers().map_err(|error| broken(path, &error))?;
        let columns = COLUMNS.map(|name| {
            let places: Vec<usize> = (0..header.len())
                .filter(|place| {
                    let cell = header.get(*place).unwrap_or_default();
                    let cell = cell.strip_prefix(b"\xef\xbb\xbf").unwrap_or(cell);
                    cell.trim_ascii() == name.as_bytes()
                })
                .collect();
            match places[..] {
                [place] => Ok(place),
                [] => Err(format!("the header has no column {name}")),
                _ => Err(format!("the header has {} columns {name}", places.len())),
            }
        });
        let mut found = [0; 6];
        for (found, column) in found.iter_mut().zip(columns) {
            *found = column.map_err(|what| {
                let all = COLUMNS.join(",");
                CliError::in_file(path, 1, format_args!("{what}; needed are {all} in any order"))
            })?;
        }
        Ok(Self {
            path: path.to_owned(),
            reader,
            columns: found,
            record: ByteRecord::new(),
            row_began,
        })
    }

    /// The next row, if there is one.
    pub(super) fn next(&mut self) -> Result<Option<Row>, CliError> {
        self.row_began.set(self.reader.position().byte());
        let there = self.reader.read_byte_record(&mut self.record);
        if !there.map_err(|error| broken(&self.path, &error))? {
            return Ok(None);
        }
        let line = self.record.position().map_or(0, csv::Position::line);
        let wrong = |what: String| CliError::in_file(&self.path, line, what);
        let mut fields = ByteRecord::new();
        let mut numbers = [0.0; 6];
        for ((number, column), name) in numbers.iter_mut().zip(self.columns).zip(COLUMNS) {
            let field = self.record.get(column).ok_or_else(|| {
                wrong(format!("{} fields: there is no {name}", self.record.len()))
            })?;
            fields.push_field(field);
            let text = str::from_utf8(field).ok().map(str::trim);
            *number = text
                .and_then(|text| text.parse::<f64>().ok())
                .filter(|number| number.is_finite())
                .ok_or_else(|| {
                    wrong(format!("{name} is \"{}\", no finite number", field.escape_ascii()))
                })?;
        }
        let [x, y, degrees @ ..] = numbers;
        let texel = |number: f64, name: &str| {
            // Beyond 2^53 neighbours are not told apart.
            if number.fract() == 0.0 && number.abs() <= 9e15 {
                Ok(number as i64)
            } else {
                Err(wrong(format!("{name} is {number}, no number of a texel")))
            }
        };
        let asked = Asked { x: texel(x, "x")?, y: texel(y, "y")?, degrees };
        Ok(Some(Row { asked, fields }))
    }

    /// Bytes read so far.
    pub(super) fn position(&self) -> u64 {
        self.reader.position().byte()
    }
}

fn broken(path: &Path, error: &csv::Error) -> CliError {
    match error.kind() {
        csv::ErrorKind::Io(error) => CliError::io(path, "read", error),
        _ => CliError::new(format!("{}: {error}", path.display())),
    }
}

/// A source whose rows are not longer than [`LONGEST_ROW`].
struct Bounded<R> {
    source: R,
    given: u64,
    row_began: Rc<Cell<u64>>,
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.given - self.row_began.get().min(self.given) > LONGEST_ROW {
            return Err(io::Error::other(format!(
                "the row at byte {} is longer than {LONGEST_ROW} bytes",
                self.row_began.get()
            )));
        }
        let count = self.source.read(buffer)?;
        self.given += count as u64;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> Result<Vec<Row>, String> {
        let mut queries =
            Queries::new(Path::new("in.csv"), text.as_bytes()).map_err(|e| e.to_string())?;
        let mut rows = Vec::new();
        while let Some(row) = queries.next().map_err(|e| e.to_string())? {
            rows.push(row);
        }
        Ok(rows)
    }

    #[test]
    fn columns_come_in_any_order_and_others_are_ignored() {
        let text =
            "\u{feff}phi_v,x,note, theta_i,y,phi_i,theta_v\r\n6, -1,\"a, b\",3.0,2,4,5e0\r\n";
        let rows = all(text).unwrap();
        assert_eq!(rows.len(), 1);
        assert_eq!(rows[0].asked, Asked { x: -1, y: 2, degrees: [3.0, 4.0, 5.0, 6.0] });
        let fields: Vec<&[u8]> = rows[0].fields.iter().collect();
        assert_eq!(fields, [&b" -1"[..], b"2", b"3.0", b"4", b"5e0", b"6"]);
    }

    #[test]
    fn errors_have_lines() {
        let header = "x,y,theta_i,phi_i,theta_v,phi_v\n";
        for (row, message) in [
            ("1,2,3,4,5\n", "in.csv:3: 5 fields: there is no phi_v"),
            ("1,2,3,x4,5,6\n", "in.csv:3: phi_i is \"x4\""),
            ("1,2,3,4,NaN,6\n", "in.csv:3: theta_v is \"NaN\""),
            ("1,2,3,4,5,1e999\n", "in.csv:3: phi_v"),
            ("1.5,2,3,4,5,6\n", "in.csv:3: x is 1.5"),
            ("1,1e300,3,4,5,6\n", "in.csv:3: y is 1"),
        ] {
            let error = all(&format!("{header}0,0,0,0,0,0\n{row}")).err().unwrap_or_default();
            assert!(error.starts_with(message), "{row}: {error}");
        }
        let error = all("x,y,theta_i,phi_i,theta_v\n").err().unwrap_or_default();
        assert!(error.contains("in.csv:1") && error.contains("no column phi_v"), "{error}");
        let error = all("x,x,y,theta_i,phi_i,theta_v,phi_v\n").err().unwrap_or_default();
        assert!(error.contains("2 columns x"), "{error}");
        assert!(all("").is_err());
    }

    #[test]
    fn a_row_without_end_is_refused() {
        let header = "x,y,theta_i,phi_i,theta_v,phi_v\n0,0,0,0,0,0\n".as_bytes();
        let endless = header.chain(io::repeat(b'1'));
        let mut queries =
            Queries::new(Path::new("in.csv"), endless).unwrap_or_else(|e| panic!("{e}"));
        assert!(queries.next().is_ok());
        let error = queries.next().err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains("longer than"), "{error}");
    }
}
