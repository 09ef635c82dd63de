//! Arrays of equal elements, compressed in pieces.
//!
//! A piece holds up to [`PIECE`] bytes of one array. It begins with a byte that says how it is
//! packed ([`Form`]); for the compressed ones the count of compressed bytes (LEB128) and those
//! follow. Before compression the bytes are turned into planes (all first bytes, then all second
//! bytes and so on), so that the slowly varying high bytes of floats and indices stand together, and
//! optionally every element is replaced by its difference to the one before. The encoder takes the
//! smallest form.

use std::marker::PhantomData;

use glam::{Vec2, Vec3};

use super::Columns;
use crate::{
    WireError,
    codec::{Reader, Writer},
};

/// Bytes of a piece before compression: small beside a blob, large for LZ4.
const PIECE: usize = 256 << 10;
/// LZ4 gives at most so many bytes for one: a byte of a length stands for 255.
const EXPANSION: usize = 255;
/// Words of the widest element.
const WORDS: usize = 3;

/// How a piece is packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// As it is: compression doesn't help.
    Plain,
    /// LZ4 of planes.
    Planes,
    /// LZ4 of planes of differences.
    Differences,
}

/// An element of an array: up to three little-endian words of 32 bits.
pub(super) trait Element: Copy {
    const WORDS: usize;
    const BYTES: usize = Self::WORDS * 4;

    fn to_words(self) -> [u32; WORDS];
    fn from_words(words: [u32; WORDS]) -> Self;

    /// The word `a` as seen from `b`.
    fn difference(a: u32, b: u32) -> u32 {
        a.wrapping_sub(b)
    }

    /// Undoes [`difference`](Self::difference).
    fn sum(difference: u32, b: u32) -> u32 {
        difference.wrapping_add(b)
    }
}

impl Element for Vec3 {
    const WORDS: usize = 3;

    fn to_words(self) -> [u32; WORDS] {
        self.to_array().map(f32::to_bits)
    }

    fn from_words(words: [u32; WORDS]) -> Self {
        Self::from_array(words.map(f32::from_bits))
    }
}

impl Element for Vec2 {
    const WORDS: usize = 2;

    fn to_words(self) -> [u32; WORDS] {
        [self.x.to_bits(), self.y.to_bits(), 0]
    }

    fn from_words([x, y, _]: [u32; WORDS]) -> Self {
        Self::new(f32::from_bits(x), f32::from_bits(y))
    }
}

/// Corners of a triangle.
impl Element for [u32; 3] {
    const WORDS: usize = 3;

    fn to_words(self) -> [u32; WORDS] {
        self
    }

    fn from_words(words: [u32; WORDS]) -> Self {
        words
    }
}

/// A texel. Its bytes are apart: a difference doesn't carry from one to the next.
impl Element for [u8; 4] {
    const WORDS: usize = 1;

    fn to_words(self) -> [u32; WORDS] {
        [u32::from_le_bytes(self), 0, 0]
    }

    fn from_words([word, ..]: [u32; WORDS]) -> Self {
        word.to_le_bytes()
    }

    fn difference(a: u32, b: u32) -> u32 {
        let (a, b) = (a.to_le_bytes(), b.to_le_bytes());
        u32::from_le_bytes(std::array::from_fn(|i| a[i].wrapping_sub(b[i])))
    }

    fn sum(difference: u32, b: u32) -> u32 {
        let (d, b) = (difference.to_le_bytes(), b.to_le_bytes());
        u32::from_le_bytes(std::array::from_fn(|i| d[i].wrapping_add(b[i])))
    }
}

/// Elements of a piece.
pub(super) fn piece<E: Element>() -> usize {
    PIECE / E::BYTES
}

/// Appends the elements as they are.
pub(super) fn plain<E: Element>(values: &[E], out: &mut Vec<u8>) {
    for value in values {
        for word in &value.to_words()[..E::WORDS] {
            out.extend_from_slice(&word.to_le_bytes());
        }
    }
}

fn from_plain<E: Element>(bytes: &[u8], out: &mut Vec<E>) {
    out.extend(bytes.chunks_exact(E::BYTES).map(|bytes| {
        let mut words = [0; WORDS];
        for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(4)) {
            *word = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        }
        E::from_words(words)
    }));
}

/// Fills `out` (`values.len() * E::BYTES` bytes) with planes.
fn to_planes<E: Element>(values: &[E], differences: bool, out: &mut [u8]) {
    let mut before = [0; WORDS];
    for (i, value) in values.iter().enumerate() {
        let words = value.to_words();
        for w in 0..E::WORDS {
            let word = if differences { E::difference(words[w], before[w]) } else { words[w] };
            for (b, byte) in word.to_le_bytes().into_iter().enumerate() {
                out[(w * 4 + b) * values.len() + i] = byte;
            }
        }
        before = words;
    }
}

fn from_planes<E: Element>(planes: &[u8], differences: bool, out: &mut Vec<E>) {
    let count = planes.len() / E::BYTES;
    let mut before = [0; WORDS];
    out.extend((0..count).map(|i| {
        let mut words = [0; WORDS];
        for (w, word) in words.iter_mut().take(E::WORDS).enumerate() {
            let bytes = std::array::from_fn(|b| planes[(w * 4 + b) * count + i]);
            *word = u32::from_le_bytes(bytes);
            if differences {
                *word = E::sum(*word, before[w]);
            }
        }
        before = words;
        E::from_words(words)
    }));
}

/// Packs arrays.
pub(super) struct Packer {
    out: Writer,
    planes: Vec<u8>,
    /// The smallest form so far, and the one being tried.
    best: Vec<u8>,
    trial: Vec<u8>,
}

impl Packer {
    /// Begins with the bytes `head`.
    pub(super) fn new(head: Vec<u8>) -> Self {
        let mut out = Writer::default();
        out.raw(&head);
        Self { out, planes: Vec::new(), best: Vec::new(), trial: Vec::new() }
    }

    pub(super) fn finish(self) -> Vec<u8> {
        self.out.finish()
    }

    fn piece<E: Element>(&mut self, values: &[E]) {
        let bytes = values.len() * E::BYTES;
        self.planes.resize(bytes, 0);
        self.trial.resize(lz4_flex::block::get_maximum_output_size(bytes), 0);
        let mut form = Form::Plain;
        for candidate in [Form::Planes, Form::Differences] {
            to_planes(values, candidate == Form::Differences, &mut self.planes);
            // It can't fail: there is room for the worst case.
            let Ok(size) = lz4_flex::block::compress_into(&self.planes, &mut self.trial) else {
                continue;
            };
            let smallest = if form == Form::Plain { bytes } else { self.best.len() };
            if size < smallest {
                form = candidate;
                self.best.clear();
                self.best.extend_from_slice(&self.trial[..size]);
            }
        }
        self.out.u8(form as u8);
        if form == Form::Plain {
            self.planes.clear();
            plain(values, &mut self.planes);
            self.out.raw(&self.planes);
        } else {
            self.out.bytes(&self.best);
        }
    }
}

impl Columns for Packer {
    fn column<E: Element>(&mut self, values: &[E]) {
        for values in values.chunks(piece::<E>()) {
            self.piece(values);
        }
    }
}

/// An array that is still packed; its memory is accounted for.
pub(super) struct Column<E> {
    len: usize,
    element: PhantomData<E>,
}

impl<E> Column<E> {
    pub(super) fn len(&self) -> usize {
        self.len
    }
}

/// Unpacks arrays within a limit.
pub(super) struct Unpacker {
    what: &'static str,
    limit: usize,
    bytes: usize,
    buffer: Vec<u8>,
}

impl Unpacker {
    /// All arrays together may take `limit` bytes.
    pub(super) fn new(what: &'static str, limit: usize) -> Self {
        Self { what, limit, bytes: 0, buffer: Vec::new() }
    }

    /// Accounts for an array of `len` elements.
    pub(super) fn column<E: Element>(&mut self, len: u64) -> Result<Column<E>, WireError> {
        let bytes = len.saturating_mul(E::BYTES as u64).saturating_add(self.bytes as u64);
        if bytes > self.limit as u64 {
            let limit = self.limit as u64;
            return Err(WireError::TooLarge { what: self.what, found: bytes, limit });
        }
        self.bytes = bytes as usize;
        Ok(Column { len: len as usize, element: PhantomData })
    }

    /// Call it when all arrays are accounted for: holds their size against what there is.
    pub(super) fn start(&self, reader: &Reader<'_>) -> Result<(), WireError> {
        let possible = reader.rest().len().saturating_mul(EXPANSION);
        if self.bytes <= possible {
            return Ok(());
        }
        Err(reader.invalid("it says that it is larger than its bytes can hold"))
    }

    /// Unpacks an array.
    pub(super) fn read<E: Element>(
        &mut self,
        reader: &mut Reader<'_>,
        column: Column<E>,
    ) -> Result<Vec<E>, WireError> {
        let mut values = Vec::with_capacity(column.len);
        while values.len() < column.len {
            let count = piece::<E>().min(column.len - values.len());
            self.piece(reader, count * E::BYTES, &mut values)?;
        }
        Ok(values)
    }

    fn piece<E: Element>(
        &mut self,
        reader: &mut Reader<'_>,
        bytes: usize,
        values: &mut Vec<E>,
    ) -> Result<(), WireError> {
        let form = match reader.u8()? {
            0 => {
                from_plain(reader.raw(bytes)?, values);
                return Ok(());
            }
            1 => Form::Planes,
            2 => Form::Differences,
            other => return Err(reader.invalid(format_args!("there is no form {other}"))),
        };
        let packed = reader.bytes(bytes)?;
        if bytes > packed.len().saturating_mul(EXPANSION) {
            return Err(reader.invalid("a piece can't be that large"));
        }
        self.buffer.resize(bytes, 0);
        match lz4_flex::block::decompress_into(packed, &mut self.buffer) {
            Ok(size) if size == bytes => {}
            Ok(size) => {
                let why = format_args!("a piece has {size} bytes instead of {bytes}");
                return Err(reader.invalid(why));
            }
            Err(error) => return Err(reader.invalid(error)),
        }
        from_planes(&self.buffer, form == Form::Differences, values);
        Ok(())
    }
}

/// Elements have no padding, so that sizes on the wire are sizes in memory.
const _: () = {
    assert!(size_of::<Vec3>() == <Vec3 as Element>::BYTES);
    assert!(size_of::<Vec2>() == <Vec2 as Element>::BYTES);
};
