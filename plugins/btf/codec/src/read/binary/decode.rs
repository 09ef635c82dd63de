//! Lines, packed integers and codes of a BTFbase binary.

use crate::BtfError;

/// More entries than this in one table are refused: 2^26.
const LIMIT: usize = 1 << 26;
/// The longest line.
const LONGEST_LINE: usize = 1 << 12;

type Result<T> = std::result::Result<T, BtfError>;

/// A table of numbers in 256 steps: `min + code * (max - min) / 256`. A file holds codes 0 to 255.
#[derive(Clone, Debug)]
pub(in crate::read) struct Codes {
    pub(in crate::read) name: &'static str,
    pub(in crate::read) columns: usize,
    /// Least and greatest number.
    pub(in crate::read) range: [f32; 2],
    pub(in crate::read) codes: Vec<u16>,
}

impl Codes {
    /// The number of a code.
    pub(in crate::read) fn decode(&self, code: u16) -> f32 {
        let [min, max] = self.range;
        min + f32::from(code) * ((max - min) / 256.0)
    }

    /// The number of an entry.
    pub(in crate::read) fn value(&self, entry: usize) -> f32 {
        self.decode(self.codes[entry])
    }

    pub(in crate::read) fn values(&self) -> Vec<f32> {
        self.codes.iter().map(|code| self.decode(*code)).collect()
    }
}

/// Reads from the front of some bytes.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The next lines, without their ends.
    pub(super) fn lines(&mut self, count: usize) -> Result<Vec<&'a str>> {
        (1..=count).map(|number| self.line(number)).collect()
    }

    fn line(&mut self, number: usize) -> Result<&'a str> {
        let wrong = |what: &str| BtfError::Tables(format!("line {number} {what}"));
        let rest = &self.bytes[self.at..];
        let end = rest.iter().take(LONGEST_LINE).position(|byte| *byte == b'\n');
        let end = end.ok_or_else(|| wrong("does not end"))?;
        self.at += end + 1;
        str::from_utf8(&rest[..end]).map_err(|_| wrong("is no text"))
    }

    fn take(&mut self, name: &str, count: usize) -> Result<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let taken = rest.get(..count).ok_or_else(|| {
            BtfError::Tables(format!(
                "cut off in {name}: at byte {}, {} bytes are left and {count} needed",
                self.at,
                rest.len()
            ))
        })?;
        self.at += count;
        Ok(taken)
    }

    fn word(&mut self, name: &str) -> Result<[u8; 4]> {
        Ok(self.take(name, 4)?.try_into().unwrap_or_default())
    }

    /// Whether a table of this shape may be: so large that memory stays in proportion to the file.
    fn entries(&self, name: &str, [rows, columns]: [usize; 2]) -> Result<usize> {
        let most = LIMIT.min(self.bytes.len().saturating_mul(8));
        rows.checked_mul(columns)
            .filter(|count| (1..=most).contains(count))
            .ok_or_else(|| BtfError::Tables(format!("{name} of {rows} rows and {columns} columns")))
    }

    /// A table of integers: least, greatest, then as many bits each as their difference needs,
    /// from the lowest bit of the first byte on.
    pub(super) fn integers(&mut self, name: &str, shape: [usize; 2]) -> Result<Vec<u32>> {
        let count = self.entries(name, shape)?;
        let min = i32::from_le_bytes(self.word(name)?);
        let max = i32::from_le_bytes(self.word(name)?);
        if min < 0 || max < min {
            return Err(BtfError::Tables(format!("{name} from {min} to {max}")));
        }
        let width = (max - min).checked_ilog2().map_or(0, |log| log + 1);
        let packed = self.take(name, packed_bytes(count, width))?;
        let mut bytes = packed.iter();
        let (mut bits, mut available) = (0_u64, 0);
        let mask = (1_u64 << width) - 1;
        let decoded = (0..count).map(|_| {
            while available < width {
                // The length was checked above.
                bits |= u64::from(bytes.next().copied().unwrap_or_default()) << available;
                available += 8;
            }
            let code = (bits & mask) as u32;
            bits >>= width;
            available -= width;
            min as u32 + code
        });
        Ok(decoded.collect())
    }

    /// A table of numbers: least, greatest, rows, columns, then a byte each.
    pub(super) fn codes(&mut self, name: &'static str, shape: [usize; 2]) -> Result<Codes> {
        let count = self.entries(name, shape)?;
        let range = [0; 2].map(|_: i32| self.word(name).map(f32::from_le_bytes));
        let [min, max] = range;
        let (min, max) = (min?, max?);
        let rows = i32::from_le_bytes(self.word(name)?);
        let columns = i32::from_le_bytes(self.word(name)?);
        if [rows, columns].map(|count| usize::try_from(count).ok()) != shape.map(Some) {
            return Err(BtfError::Tables(format!(
                "{name} of {rows} rows and {columns} columns instead of {} and {}",
                shape[0], shape[1]
            )));
        }
        if !(min.is_finite() && (max - min).is_finite() && min <= max) {
            return Err(BtfError::Tables(format!("{name} from {min} to {max}")));
        }
        let bytes = self.take(name, packed_bytes(count, 8))?;
        Ok(Codes {
            name,
            columns: shape[1],
            range: [min, max],
            codes: bytes[..count].iter().map(|code| u16::from(*code)).collect(),
        })
    }

    /// Fails if something is left.
    pub(super) fn end(&self) -> Result<()> {
        match self.bytes.len() - self.at {
            0 => Ok(()),
            left => Err(BtfError::Tables(format!("{left} bytes after the last table"))),
        }
    }
}

/// Bytes of `count` codes of `width` bits: whole 32-bit words, and always one begun for a rest.
fn packed_bytes(count: usize, width: u32) -> usize {
    (count * width as usize / 32 + 1) * 4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_lie_lowest_bit_first() {
        // 3 bits each, least 2: codes 1, 7, 0, 5.
        let mut bytes = [2_i32, 9].map(i32::to_le_bytes).concat();
        bytes.extend((0b101_000_111_001_u32).to_le_bytes());
        let mut cursor = Cursor::new(&bytes);
        assert_eq!(cursor.integers("t", [2, 2]).unwrap(), [3, 9, 2, 7]);
        assert!(cursor.end().is_ok());
        assert!(Cursor::new(&bytes).integers("t", [1, 12]).is_err());
        assert!(Cursor::new(&bytes[..11]).integers("t", [2, 2]).is_err());
    }

    #[test]
    fn equal_integers_take_one_word() {
        let bytes = [4_i32, 4, 0].map(i32::to_le_bytes).concat();
        let mut cursor = Cursor::new(&bytes);
        assert_eq!(cursor.integers("t", [3, 1]).unwrap(), [4, 4, 4]);
        assert!(cursor.end().is_ok());
        // A few bytes do not make a large table.
        assert!(Cursor::new(&bytes).integers("t", [1 << 20, 2]).is_err());
    }

    #[test]
    fn codes_are_steps_of_a_256th() {
        let mut bytes = [1.0_f32, 3.0].map(f32::to_le_bytes).concat();
        bytes.extend([1_i32, 3].map(i32::to_le_bytes).concat());
        bytes.extend([0, 128, 255, 0]);
        let codes = Cursor::new(&bytes).codes("t", [1, 3]).unwrap();
        assert_eq!(codes.values(), [1.0, 2.0, 1.0 + 255.0 / 128.0]);
        assert_eq!(codes.decode(256), 3.0);
        assert!(Cursor::new(&bytes).codes("t", [3, 1]).is_err());
    }
}
