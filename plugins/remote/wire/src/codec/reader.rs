//! Bytes to values, believing nothing.

use crate::WireError;

/// Reads little-endian values off the front of bytes. Every method fails with
/// [`WireError::Truncated`] where the bytes end, and no method takes memory that the bytes don't
/// account for.
#[derive(Clone, Debug)]
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
    what: &'static str,
}

macro_rules! numbers {
    ($($name:ident)*) => {$(
        pub(crate) fn $name(&mut self) -> Result<$name, WireError> {
            Ok($name::from_le_bytes(self.array()?))
        }
    )*};
}

impl<'a> Reader<'a> {
    /// Reads `bytes`, which are called `what` in errors.
    pub(crate) fn new(what: &'static str, bytes: &'a [u8]) -> Self {
        Self { rest: bytes, what }
    }

    numbers!(u8 u16 u32 u64 f32);

    /// As they are.
    pub(crate) fn raw(&mut self, count: usize) -> Result<&'a [u8], WireError> {
        match self.rest.split_at_checked(count) {
            Some((bytes, rest)) => {
                self.rest = rest;
                Ok(bytes)
            }
            None => Err(WireError::Truncated { what: self.what, missing: count - self.rest.len() }),
        }
    }

    pub(crate) fn array<const N: usize>(&mut self) -> Result<[u8; N], WireError> {
        let mut array = [0; N];
        array.copy_from_slice(self.raw(N)?);
        Ok(array)
    }

    /// See [`Writer::varint`](super::Writer::varint).
    pub(crate) fn varint(&mut self) -> Result<u64, WireError> {
        let mut value = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.u8()?;
            let bits = u64::from(byte & 0x7f);
            if shift == 63 && bits > 1 {
                break;
            }
            value |= bits << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(self.invalid("a number has more than 64 bits"))
    }

    /// A count of things of at least `each` bytes (at least 1), of which there may be `limit`.
    pub(crate) fn count(&mut self, each: usize, limit: usize) -> Result<usize, WireError> {
        let found = self.varint()?;
        if found > limit as u64 {
            return Err(WireError::TooLarge { what: self.what, found, limit: limit as u64 });
        }
        let needed = (found as usize).saturating_mul(each.max(1));
        if needed > self.rest.len() {
            let missing = needed - self.rest.len();
            return Err(WireError::Truncated { what: self.what, missing });
        }
        Ok(found as usize)
    }

    /// A count and bytes.
    pub(crate) fn bytes(&mut self, limit: usize) -> Result<&'a [u8], WireError> {
        let count = self.count(1, limit)?;
        self.raw(count)
    }

    /// Text in UTF-8.
    pub(crate) fn text(&mut self, limit: usize) -> Result<&'a str, WireError> {
        let bytes = self.bytes(limit)?;
        std::str::from_utf8(bytes).map_err(|_| self.invalid("a text is not UTF-8"))
    }

    /// Floats that must be finite.
    pub(crate) fn floats<const N: usize>(&mut self) -> Result<[f32; N], WireError> {
        let mut floats = [0.0; N];
        for float in &mut floats {
            *float = self.f32()?;
        }
        if floats.iter().all(|f| f.is_finite()) {
            return Ok(floats);
        }
        Err(self.invalid("a number is not finite"))
    }

    /// 0 or 1.
    pub(crate) fn flag(&mut self) -> Result<bool, WireError> {
        match self.u8()? {
            0 => Ok(false),
            1 => Ok(true),
            other => Err(self.invalid(format_args!("{other} is neither no nor yes"))),
        }
    }

    /// Nothing may be left.
    pub(crate) fn end(&self) -> Result<(), WireError> {
        match self.rest.len() {
            0 => Ok(()),
            more => Err(self.invalid(format_args!("{more} bytes follow it"))),
        }
    }

    /// What is left.
    pub(crate) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    pub(crate) fn invalid(&self, why: impl std::fmt::Display) -> WireError {
        WireError::invalid(self.what, why)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::Writer;

    #[test]
    fn numbers_come_back() {
        let mut writer = Writer::default();
        let numbers = [0, 1, 127, 128, 300, u64::from(u32::MAX), u64::MAX - 1, u64::MAX];
        numbers.into_iter().for_each(|n| writer.varint(n));
        writer.f32(1.5);
        writer.bytes(b"abc");
        let bytes = writer.finish();
        let mut reader = Reader::new("numbers", &bytes);
        for n in numbers {
            assert_eq!(reader.varint(), Ok(n));
        }
        assert_eq!(reader.f32(), Ok(1.5));
        assert_eq!(reader.text(3), Ok("abc"));
        assert!(reader.rest().is_empty());
        assert_eq!(reader.u8(), Err(WireError::Truncated { what: "numbers", missing: 1 }));
    }

    #[test]
    fn numbers_that_never_end_are_refused() {
        assert!(Reader::new("x", &[0xff; 20]).varint().is_err());
        let mut eleven = [0x80; 10];
        eleven[9] = 2;
        assert!(Reader::new("x", &eleven).varint().is_err(), "65 bits");
    }

    #[test]
    fn counts_are_held_against_what_is_there() {
        let mut writer = Writer::default();
        writer.count(1 << 40);
        let huge = writer.finish();
        let too_large = Reader::new("x", &huge).count(1, 1 << 20);
        assert!(matches!(too_large, Err(WireError::TooLarge { .. })));
        let truncated = Reader::new("x", &huge).count(8, usize::MAX);
        assert!(matches!(truncated, Err(WireError::Truncated { .. })));
    }
}
