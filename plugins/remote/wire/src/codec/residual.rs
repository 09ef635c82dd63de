//! Adaptive codes for prediction errors.
//!
//! An error is coded as its bit length (a tree of four decisions), its sign and the bits behind the
//! leading one, of which all but the first two are taken as they are. The probabilities are learned while coding, apart for every context; a context is a
//! class of magnitudes that was seen nearby. Two contexts are asked at once and averaged, so that
//! neither has to be fine enough alone. Before anything is learned they assume that errors in a
//! class are distributed exponentially around 0, with the scale of the class.

use super::range::BitCoder;

/// The probability of a decision, learned.
#[derive(Clone, Copy, Debug)]
struct Chance {
    /// Of 65536.
    one: u16,
    /// How much was seen, up to [`MEMORY`].
    seen: u16,
}

/// Decisions that a probability is averaged over at most.
const MEMORY: u16 = 60;
/// As how many seen decisions the assumption counts.
const ASSUMED: u16 = 4;
/// No decision is more certain than this of 65536.
const LEAST: u32 = 32;

/// `65536 / (seen + 1.5)`.
static RATES: [u32; MEMORY as usize + 1] = {
    let mut rates = [0; MEMORY as usize + 1];
    let mut seen = 0;
    while seen < rates.len() {
        rates[seen] = (2 << 16) / (2 * seen as u32 + 3);
        seen += 1;
    }
    rates
};

impl Chance {
    const EVEN: Self = Self { one: 1 << 15, seen: ASSUMED };

    fn new(one: f64) -> Self {
        Self { one: (one * 65536.0).clamp(256.0, 65280.0) as u16, seen: ASSUMED }
    }

    #[inline(always)]
    fn learn(&mut self, bit: bool) {
        let target = 65535 * i64::from(bit);
        let step = (target - i64::from(self.one)) * i64::from(RATES[usize::from(self.seen)]);
        self.one = (i64::from(self.one) + (step >> 16)) as u16;
        self.seen = (self.seen + 1).min(MEMORY);
    }

    #[inline(always)]
    fn code(&mut self, coder: &mut impl BitCoder, bit: bool) -> bool {
        let bit = coder.bit(bit, u32::from(self.one).clamp(LEAST, 65536 - LEAST));
        self.learn(bit);
        bit
    }
}

/// A decision that two contexts know something about.
#[inline(always)]
fn code_both(coder: &mut impl BitCoder, a: &mut Chance, b: &mut Chance, bit: bool) -> bool {
    let one = (u32::from(a.one) + u32::from(b.one)) / 2;
    let bit = coder.bit(bit, one.clamp(LEAST, 65536 - LEAST));
    a.learn(bit);
    b.learn(bit);
    bit
}

/// Classes of magnitudes, two an octave.
pub(crate) const CLASSES: usize = 20;
/// Coarse classes, one an octave.
pub(crate) const COARSE: usize = 7;

/// The class of a magnitude.
#[inline]
pub(crate) fn class(magnitude: u32) -> usize {
    if magnitude < 2 {
        return magnitude as usize;
    }
    let octave = magnitude.ilog2();
    let half = magnitude >> (octave - 1) & 1;
    ((2 * octave + half) as usize).min(CLASSES - 1)
}

/// The coarse class of a magnitude.
#[inline]
pub(crate) fn coarse(magnitude: u32) -> usize {
    (class(magnitude) / 2).min(COARSE - 1)
}

/// A typical magnitude of a class.
fn scale(class: usize) -> f64 {
    match class {
        0 => 0.5,
        1 => 1.2,
        _ => (1_u32 << (class / 2)) as f64 * if class.is_multiple_of(2) { 1.25 } else { 1.75 },
    }
}

/// Probabilities of the bit lengths 0..=15: nodes 1..16 of a binary tree.
type Lengths = [Chance; 16];

/// `e^-x` by nothing but products, which are the same on every machine.
fn decay(x: f64) -> f64 {
    let mut y = (1.0 - x / 4096.0).max(0.0);
    for _ in 0..12 {
        y *= y;
    }
    y
}

/// What is assumed of a class.
fn assumed(class: usize) -> Lengths {
    let scale = scale(class);
    // The probability of at least so many bits.
    let at_least = |length: u32| match length {
        0 => 1.0,
        16.. => 0.0,
        _ => decay((f64::from(1_u32 << (length - 1)) - 0.5) / scale),
    };
    let mut lengths = [Chance::EVEN; 16];
    for node in 1..16_u32 {
        let depth = node.ilog2();
        let size = 16 >> depth;
        let first = (node - (1 << depth)) * size;
        let all = at_least(first) - at_least(first + size);
        let upper = at_least(first + size / 2) - at_least(first + size);
        let one = if all > 1e-9 { upper / all } else { 0.5 };
        lengths[node as usize] = Chance::new(one);
    }
    lengths
}

/// What is known nearby about the size of an error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Context {
    /// First opinion: a class and a coarse class.
    pub(crate) first: (usize, usize),
    /// Second opinion.
    pub(crate) second: (usize, usize),
    /// What the sign may depend on, below [`SIGNS`].
    pub(crate) sign: usize,
}

/// Contexts of the sign.
pub(crate) const SIGNS: usize = 9;

/// Learns to code errors of one kind.
#[derive(Debug)]
pub(crate) struct Residuals {
    first: Vec<Lengths>,
    second: Vec<Lengths>,
    signs: [Chance; SIGNS],
    /// The two bits behind the leading one, by length and what is known of the number.
    bits: [[Chance; 4]; 16],
}

impl Residuals {
    pub(crate) fn new() -> Self {
        let classes = (0..CLASSES).flat_map(|c| [assumed(c); COARSE]);
        let first: Vec<Lengths> = classes.collect();
        let second = first.clone();
        Self { first, second, signs: [Chance::EVEN; SIGNS], bits: [[Chance::EVEN; 4]; 16] }
    }

    /// Codes an error; its magnitude must be below 2^15.
    #[inline]
    pub(crate) fn code(&mut self, coder: &mut impl BitCoder, context: Context, error: i32) -> i32 {
        let magnitude = error.unsigned_abs();
        let length = u32::BITS - magnitude.leading_zeros();
        let first = &mut self.first[context.first.0 * COARSE + context.first.1];
        let second = &mut self.second[context.second.0 * COARSE + context.second.1];
        let mut node = 1;
        for shift in [3, 2, 1, 0] {
            let bit = length >> shift & 1 == 1;
            let bit = code_both(coder, &mut first[node], &mut second[node], bit);
            node = 2 * node + usize::from(bit);
        }
        let length = node as u32 - 16;
        if length == 0 {
            return 0;
        }
        let negative = self.signs[context.sign].code(coder, error < 0);
        let mut known = 1;
        for place in 1..length.min(3) {
            let bit = magnitude >> (length - 1 - place) & 1 == 1;
            let chance = &mut self.bits[length as usize][known as usize];
            known = 2 * known + u32::from(chance.code(coder, bit));
        }
        if let Some(more) = length.checked_sub(3) {
            known = known << more | coder.raw(magnitude, more);
        }
        if negative { -(known as i32) } else { known as i32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::range::{RangeDecoder, RangeEncoder};

    fn context(i: usize) -> Context {
        Context {
            first: (i % CLASSES, i % COARSE),
            second: (i / 3 % CLASSES, i / 5 % COARSE),
            sign: i % SIGNS,
        }
    }

    #[test]
    fn errors_come_back() {
        let mut errors = vec![0, 1, -1, 2, -3, 4, 32767, -32767, 16384, -16383];
        errors.extend((0..5000).map(|i: i32| (i * 7919 % 3001 - 1500) >> (i % 11)));
        let (mut encoder, mut model) = (RangeEncoder::new(), Residuals::new());
        for (i, &error) in errors.iter().enumerate() {
            assert_eq!(model.code(&mut encoder, context(i), error), error);
        }
        let bytes = encoder.finish();
        let mut decoder = RangeDecoder::new("a test", &bytes).unwrap();
        let mut model = Residuals::new();
        for (i, &error) in errors.iter().enumerate() {
            assert_eq!(model.code(&mut decoder, context(i), 0), error, "{i}");
        }
    }

    #[test]
    fn certainty_is_nearly_free_but_not_quite() {
        let (mut encoder, mut model) = (RangeEncoder::new(), Residuals::new());
        for _ in 0..10_000 {
            model.code(&mut encoder, context(0), 0);
        }
        let size = encoder.finish().len();
        assert!((1..40).contains(&size), "{size}");
    }

    #[test]
    fn classes_grow() {
        let classes: Vec<usize> = [0, 1, 2, 3, 4, 5, 6, 8, 12, 16, 1 << 20].map(class).into();
        assert_eq!(classes, [0, 1, 2, 3, 4, 4, 5, 6, 7, 8, CLASSES - 1]);
        assert_eq!(coarse(u32::MAX), COARSE - 1);
        for class in 1..CLASSES {
            assert!(scale(class) > scale(class - 1));
        }
    }

    #[test]
    fn assumptions_fit_their_class() {
        // Half of an exponential distribution lies below 0.69 of its scale.
        for class in 4..CLASSES {
            let median = 0.69 * scale(class);
            let tree = assumed(class);
            let mut below = 0.0;
            for length in 0..16_u32 {
                if length > 0 && f64::from(1 << (length - 1)) > median {
                    break;
                }
                let mut chance = 1.0;
                let mut node = 1;
                for shift in [3, 2, 1, 0] {
                    let one = f64::from(tree[node].one) / 65536.0;
                    let bit = length >> shift & 1;
                    chance *= if bit == 1 { one } else { 1.0 - one };
                    node = 2 * node + bit as usize;
                }
                below += chance;
            }
            assert!((0.45..0.8).contains(&below), "class {class}: {below}");
        }
    }
}
