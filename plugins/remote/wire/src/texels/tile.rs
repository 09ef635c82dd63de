//! Texels: predicted from their neighbours, what is left coded adaptively.
//!
//! Green is predicted by the median edge detector of LOCO-I (Weinberger, Seroussi and Sapiro 2000,
//! "The LOCO-I lossless image compression algorithm", section III.A) from the texels to the left,
//! above and between them; red and blue by the same predictor of their difference to green, which is
//! the logarithm of a ratio and mostly smooth. How large the error will be is judged by the errors
//! at the neighbours and in green, and by how much the neighbours differ.
//!
//! Where the other side has an older state of the tile, its growth since then is predicted instead, in
//! logarithms. Light that moves changes texels much alike, and noise stays where it is, since a solver
//! keeps its rays. No context depends on the older state: a reader that lacks it still finds the
//! tiles behind.

use super::{
    octave::{half_of, log_of},
    step::{LARGEST, Step},
};
use crate::codec::{BitCoder, Context, Residuals, class, coarse};

/// Kinds of coding.
const ALONE: usize = 0;
const BESIDE: usize = 1;

const RED: usize = 0;
const GREEN: usize = 1;
const BLUE: usize = 2;

/// What the first texel of all is expected to be: the bits of 0.25.
const START: u16 = 0x3400;
/// An error that is assumed beyond the edge of a tile.
const BEYOND: u32 = 8;

/// Learns over all tiles of a message.
#[derive(Debug)]
pub(super) struct TileCoder {
    step: Step,
    /// For texels by themselves and for those beside others.
    models: [[Residuals; 3]; 2],
    /// Levels, or differences of logarithms, of the row above and of this one, with one more at the left and two at the right.
    above: Vec<[i32; 3]>,
    row: Vec<[i32; 3]>,
    /// Magnitudes of the errors there.
    errors_above: Vec<[u32; 3]>,
    errors: Vec<[u32; 3]>,
    /// The first texel of the tile before.
    start: [i32; 3],
}

/// Levels or errors around a texel.
struct Around<T> {
    left: T,
    above: T,
    above_left: T,
    above_right: T,
}

impl<T: Copy> Around<T> {
    fn map<U>(&self, f: impl Fn(T) -> U) -> Around<U> {
        Around {
            left: f(self.left),
            above: f(self.above),
            above_left: f(self.above_left),
            above_right: f(self.above_right),
        }
    }
}

impl Around<i32> {
    /// Takes the smaller neighbour at an edge, the larger one at the other kind of edge, and goes on
    /// linearly elsewhere.
    fn predict(&self) -> i32 {
        let (low, high) = (self.left.min(self.above), self.left.max(self.above));
        (self.left + self.above - self.above_left).clamp(low, high)
    }

    fn spread(&self) -> u32 {
        self.left.abs_diff(self.above_left)
            + self.above.abs_diff(self.above_left)
            + self.above.abs_diff(self.above_right)
    }
}

impl Around<u32> {
    /// What errors around make likely.
    fn usual(&self) -> u32 {
        (2 * self.left + 2 * self.above + self.above_left + self.above_right) / 4
    }
}

impl TileCoder {
    pub(super) fn new(step: Step) -> Self {
        Self {
            step,
            models: std::array::from_fn(|_| std::array::from_fn(|_| Residuals::new())),
            above: Vec::new(),
            row: Vec::new(),
            errors_above: Vec::new(),
            errors: Vec::new(),
            start: [step.level(START); 3],
        }
    }

    /// Codes the rows of a tile, `width` texels each, as they are or beside an older state. A decoder
    /// fills them in.
    pub(super) fn code(
        &mut self,
        coder: &mut impl BitCoder,
        width: usize,
        texels: &mut [[u16; 3]],
        base: Option<&[[u16; 3]]>,
    ) {
        let start = if base.is_some() { [0; 3] } else { self.start };
        for rows in [&mut self.above, &mut self.row] {
            rows.clear();
            rows.resize(width + 3, start);
        }
        for rows in [&mut self.errors_above, &mut self.errors] {
            rows.clear();
            rows.resize(width + 3, [BEYOND; 3]);
        }
        for (y, texels) in texels.chunks_exact_mut(width).enumerate() {
            for (x, texel) in texels.iter_mut().enumerate() {
                if y == 0 {
                    // Nothing is above: as if the left one was.
                    let left = self.row[x];
                    self.above[x + 1] = left;
                    self.above[x + 2] = left;
                }
                match base {
                    None => self.alone(coder, x + 1, texel),
                    // Whoever lacks the base codes beside black, and throws the tile away.
                    Some(base) => {
                        let old = base.get(y * width + x).copied().unwrap_or_default();
                        self.beside(coder, x + 1, texel, old);
                    }
                }
                if x == 0 && y == 0 && base.is_none() {
                    self.start = self.row[1];
                }
            }
            // Beyond its ends a row goes on as it ends; to the left stands what is above.
            self.row[width + 1] = self.row[width];
            let first = self.row[1];
            std::mem::swap(&mut self.above, &mut self.row);
            std::mem::swap(&mut self.errors_above, &mut self.errors);
            self.above[0] = first;
            self.row[0] = first;
        }
    }

    /// What stands around the place `x` of the row, which has its left neighbour at `x - 1`.
    fn around(&self, x: usize) -> (Around<[i32; 3]>, Around<[u32; 3]>) {
        let values = Around {
            left: self.row[x - 1],
            above: self.above[x],
            above_left: self.above[x - 1],
            above_right: self.above[x + 1],
        };
        let errors = Around {
            left: self.errors[x - 1],
            above: self.errors_above[x],
            above_left: self.errors_above[x - 1],
            above_right: self.errors_above[x + 1],
        };
        (values, errors)
    }

    /// Codes a texel by itself; rows hold levels.
    #[inline]
    fn alone(&mut self, coder: &mut impl BitCoder, x: usize, texel: &mut [u16; 3]) {
        let (levels, errors) = self.around(x);
        let wanted = texel.map(|bits| self.step.level(bits));
        let mut coded = [0; 3];
        let mut before = Before::default();
        for channel in [GREEN, RED, BLUE] {
            let plain = levels.map(|l| l[channel]);
            let (predicted, spread) = if channel == GREEN {
                (plain.predict(), plain.spread())
            } else {
                let ratio = levels.map(|l| l[channel] - l[GREEN]);
                (ratio.predict() + coded[GREEN], ratio.spread())
            };
            let predicted = predicted.clamp(0, self.step.top());
            let context = before.context(errors.map(|e| e[channel]).usual(), spread / 2);
            let error = wanted[channel] - predicted;
            let error = self.models[ALONE][channel].code(coder, context, error);
            coded[channel] = (predicted + error).clamp(0, self.step.top());
            self.errors[x][channel] = error.unsigned_abs();
            before.saw(channel, error);
        }
        self.row[x] = coded;
        *texel = coded.map(|level| self.step.bits(level));
    }

    /// Codes a texel beside an `old` state; rows hold differences of logarithms to that.
    #[inline]
    fn beside(&mut self, coder: &mut impl BitCoder, x: usize, texel: &mut [u16; 3], old: [u16; 3]) {
        let (grown, errors) = self.around(x);
        let old = old.map(log_of);
        let mut growth = [0; 3];
        let mut before = Before::default();
        for channel in [GREEN, RED, BLUE] {
            let expected = if channel == GREEN {
                grown.map(|g| g[GREEN]).predict()
            } else {
                grown.map(|g| g[channel] - g[GREEN]).predict() + growth[GREEN]
            };
            let predicted = self.step.level(half_of(old[channel] + expected));
            // Nothing here may depend on the base.
            let near = errors.map(|e| e[channel]);
            let far = near.above_left.max(near.above_right);
            let context = before.context(near.usual(), far);
            let error = self.step.level(texel[channel]) - predicted;
            let error = self.models[BESIDE][channel].code(coder, context, error);
            let level = (predicted + error).clamp(0, self.step.top());
            texel[channel] = self.step.bits(level);
            growth[channel] = log_of(texel[channel]) - old[channel];
            self.errors[x][channel] = error.unsigned_abs();
            before.saw(channel, error);
        }
        self.row[x] = growth;
    }
}

/// Errors of the channels of a texel that were coded before.
#[derive(Default)]
struct Before {
    green: i32,
    last: i32,
}

impl Before {
    fn context(&self, near: u32, spread: u32) -> Context {
        let Self { green, last } = *self;
        Context {
            first: (class(near), coarse(green.unsigned_abs())),
            second: (class(spread), coarse(last.unsigned_abs())),
            sign: (green.signum() * 3 + last.signum() + 4) as usize,
        }
    }

    fn saw(&mut self, channel: usize, error: i32) {
        self.last = error;
        if channel == GREEN {
            self.green = error;
        }
    }
}

/// Whether a tile is smoother beside an older state than by itself: by the differences of green from
/// texel to texel.
pub(super) fn is_smoother_beside(texels: &[[u16; 3]], base: &[[u16; 3]]) -> bool {
    let log = |texel: &[u16; 3]| log_of(texel[GREEN].min(LARGEST));
    let growth = |(texel, base): (&[u16; 3], &[u16; 3])| log(texel) - log(base);
    let (mut alone, mut beside) = (0, 0);
    let pairs = texels.iter().zip(base);
    for (a, b) in pairs.clone().zip(pairs.skip(1)) {
        alone += u64::from(log(a.0).abs_diff(log(b.0)));
        beside += u64::from(growth(a).abs_diff(growth(b)));
    }
    texels.len() == base.len() && beside <= alone
}
