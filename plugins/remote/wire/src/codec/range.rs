//! A binary arithmetic coder: turns yes-or-no decisions with known probabilities into bytes.
//!
//! Carry-less, after the range coder of Martin 1979 ("Range encoding: an algorithm for removing
//! redundancy from a digitised message") with a binary alphabet: the interval `low..=high` is split
//! in proportion to the probability, and leading bytes go out when both ends agree on them. 64 bits
//! wide, so what is lost while the ends straddle a byte does not matter.
//!
//! Bits that are as likely 0 as 1 go past it, packed, which is faster. The bytes are the length of
//! the arithmetic code (LEB128), the code, the packed bits.

use super::{Reader, Writer};
use crate::WireError;

/// Codes decisions. The two directions share one interface, so a model is written once and both
/// sides stay equal by construction: an encoder writes `bit` and returns it, a decoder takes no
/// notice of it and returns what it reads.
pub(crate) trait BitCoder {
    /// Codes a decision that is true with a probability of `one / 65536`; `one` is in 1..=65535.
    fn bit(&mut self, bit: bool, one: u32) -> bool;

    /// Codes the lowest `count` bits of a number (at most 16), of which nothing is known.
    fn raw(&mut self, bits: u32, count: u32) -> u32;
}

/// Where the interval is split: the lower part is for true.
fn split(low: u64, high: u64, one: u32) -> u64 {
    low + ((high - low) >> 16) * u64::from(one)
}

/// Whether both ends have the same first byte.
fn settled(low: u64, high: u64) -> bool {
    (low ^ high) >> 56 == 0
}

/// Writes decisions.
#[derive(Debug)]
pub(crate) struct RangeEncoder {
    low: u64,
    high: u64,
    out: Vec<u8>,
    packed: Vec<u8>,
    /// Packed bits that don't fill a byte yet, the newest lowest.
    pending: u64,
    count: u32,
}

impl RangeEncoder {
    pub(crate) fn new() -> Self {
        Self { low: 0, high: u64::MAX, out: Vec::new(), packed: Vec::new(), pending: 0, count: 0 }
    }

    /// The bytes. Zeros at the end of the arithmetic code are left out, the decoder reads them anyway.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        // The shortest number within the interval.
        for bytes in 0..=8 {
            let mask = u64::MAX.checked_shl(64 - 8 * bytes).unwrap_or(0);
            let number = self.high & mask;
            if number >= self.low {
                self.out.extend_from_slice(&number.to_be_bytes()[..bytes as usize]);
                break;
            }
        }
        while self.out.last() == Some(&0) {
            self.out.pop();
        }
        let mut bytes = Writer::default();
        bytes.bytes(&self.out);
        bytes.raw(&self.packed);
        if self.count > 0 {
            bytes.u8((self.pending << (8 - self.count)) as u8);
        }
        bytes.finish()
    }
}

impl BitCoder for RangeEncoder {
    #[inline]
    fn bit(&mut self, bit: bool, one: u32) -> bool {
        let middle = split(self.low, self.high, one);
        if bit {
            self.high = middle;
        } else {
            self.low = middle + 1;
        }
        while settled(self.low, self.high) {
            self.out.push((self.high >> 56) as u8);
            self.low <<= 8;
            self.high = self.high << 8 | 0xff;
        }
        bit
    }

    #[inline]
    fn raw(&mut self, bits: u32, count: u32) -> u32 {
        let bits = bits & ((1 << count) - 1);
        self.pending = self.pending << count | u64::from(bits);
        self.count += count;
        while self.count >= 8 {
            self.count -= 8;
            self.packed.push((self.pending >> self.count) as u8);
        }
        bits
    }
}

/// Reads decisions. After the end of the bytes it reads zeros, so it never fails; what it says then
/// is as meaningless as what was put in.
#[derive(Debug)]
pub(crate) struct RangeDecoder<'a> {
    low: u64,
    high: u64,
    code: u64,
    rest: std::slice::Iter<'a, u8>,
    packed: std::slice::Iter<'a, u8>,
    pending: u64,
    count: u32,
}

impl<'a> RangeDecoder<'a> {
    /// # Errors
    /// The arithmetic code is longer than the bytes.
    pub(crate) fn new(what: &'static str, bytes: &'a [u8]) -> Result<Self, WireError> {
        let mut reader = Reader::new(what, bytes);
        let rest = reader.bytes(usize::MAX)?.iter();
        let packed = reader.rest().iter();
        let mut decoder =
            Self { low: 0, high: u64::MAX, code: 0, rest, packed, pending: 0, count: 0 };
        for _ in 0..8 {
            decoder.shift();
        }
        Ok(decoder)
    }

    fn shift(&mut self) {
        self.code = self.code << 8 | u64::from(self.rest.next().copied().unwrap_or(0));
    }
}

impl BitCoder for RangeDecoder<'_> {
    #[inline]
    fn bit(&mut self, _: bool, one: u32) -> bool {
        let middle = split(self.low, self.high, one);
        let bit = self.code <= middle;
        if bit {
            self.high = middle;
        } else {
            self.low = middle + 1;
        }
        while settled(self.low, self.high) {
            self.shift();
            self.low <<= 8;
            self.high = self.high << 8 | 0xff;
        }
        bit
    }

    #[inline]
    fn raw(&mut self, _: u32, count: u32) -> u32 {
        while self.count < count {
            self.pending = self.pending << 8 | u64::from(self.packed.next().copied().unwrap_or(0));
            self.count += 8;
        }
        self.count -= count;
        (self.pending >> self.count) as u32 & ((1 << count) - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decisions with their probabilities.
    fn decisions(count: usize, skew: bool) -> Vec<(bool, u32)> {
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as u32
        };
        let decision = |_| {
            let one = if skew { 65535 } else { next() % 65535 + 1 };
            (next() % 65536 < one, one)
        };
        (0..count).map(decision).collect()
    }

    fn encode(decisions: &[(bool, u32)]) -> Vec<u8> {
        let mut encoder = RangeEncoder::new();
        for &(bit, one) in decisions {
            assert_eq!(encoder.bit(bit, one), bit);
        }
        encoder.finish()
    }

    fn decoder(bytes: &[u8]) -> RangeDecoder<'_> {
        RangeDecoder::new("a test", bytes).unwrap()
    }

    #[test]
    fn decisions_come_back() {
        for count in [0, 1, 2, 7, 100, 20_000] {
            for skew in [false, true] {
                let decisions = decisions(count, skew);
                let bytes = encode(&decisions);
                let mut decoder = decoder(&bytes);
                for &(bit, one) in &decisions {
                    assert_eq!(decoder.bit(false, one), bit);
                }
            }
        }
    }

    #[test]
    fn raw_bits_come_back_between_decisions() {
        let mut encoder = RangeEncoder::new();
        let number = |i: u32| i.wrapping_mul(40_503) >> 3;
        for i in 0..1000 {
            let bits = number(i) & ((1 << (i % 17)) - 1);
            assert_eq!(encoder.raw(number(i), i % 17), bits);
            encoder.bit(i % 3 == 0, 20_000);
        }
        let bytes = encoder.finish();
        let mut decoder = decoder(&bytes);
        for i in 0..1000 {
            assert_eq!(decoder.raw(0, i % 17), number(i) & ((1 << (i % 17)) - 1), "{i}");
            assert_eq!(decoder.bit(false, 20_000), i % 3 == 0);
        }
    }

    #[test]
    fn the_size_is_the_information() {
        let decisions = decisions(20_000, false);
        let bits: f64 = decisions
            .iter()
            .map(|&(bit, one)| {
                let one = f64::from(one) / 65536.0;
                -(if bit { one } else { 1.0 - one }).log2()
            })
            .sum();
        let size = encode(&decisions).len() as f64 * 8.0;
        assert!((bits - 16.0..bits * 1.001 + 32.0).contains(&size), "{size} for {bits} bits");
    }

    /// The narrowest interval: both ends straddle a byte.
    #[test]
    fn straddling_ends_lose_nothing() {
        let (low, high) = (0x7fff_ffff_ffff_ffff, 1 << 63);
        let mut encoder = RangeEncoder { low, high, ..RangeEncoder::new() };
        for i in 0..100 {
            encoder.bit(i % 3 == 0, 100 + 600 * i);
        }
        let bytes = encoder.finish();
        let mut decoder = RangeDecoder { low, high, ..decoder(&bytes) };
        for i in 0..100 {
            assert_eq!(decoder.bit(false, 100 + 600 * i), i % 3 == 0, "{i}");
        }
    }

    #[test]
    fn anything_can_be_read() {
        let mut decoder = decoder(&[1, 0xff, 0x12]);
        let ones = (0..1000).filter(|i| decoder.bit(false, 1 + i % 65535)).count();
        assert!(ones <= 1000);
        assert_eq!(decoder.raw(0, 8), 0x12);
        assert_eq!(decoder.raw(0, 16), 0, "beyond the end");
        assert!(RangeDecoder::new("a test", &[2, 0xff]).is_err());
        assert!(RangeDecoder::new("a test", &[]).is_err());
    }
}
