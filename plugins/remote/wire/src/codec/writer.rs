//! Values to bytes.

/// Appends little-endian values to bytes.
#[derive(Debug, Default)]
pub(crate) struct Writer(Vec<u8>);

macro_rules! numbers {
    ($($name:ident)*) => {$(
        pub(crate) fn $name(&mut self, value: $name) {
            self.0.extend_from_slice(&value.to_le_bytes());
        }
    )*};
}

impl Writer {
    numbers!(u8 u16 u32 u64 f32);

    /// A number that is mostly small: seven bits a byte, low ones first, the eighth says that more
    /// follow (LEB128).
    pub(crate) fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }

    /// A count.
    pub(crate) fn count(&mut self, count: usize) {
        self.varint(count as u64);
    }

    /// Bytes as they are.
    pub(crate) fn raw(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
    }

    /// A count and bytes.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        self.count(bytes.len());
        self.raw(bytes);
    }

    /// Floats as they are.
    pub(crate) fn floats<const N: usize>(&mut self, values: [f32; N]) {
        values.into_iter().for_each(|value| self.f32(value));
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    pub(crate) fn finish(self) -> Vec<u8> {
        self.0
    }
}
