//! Texels: predicted from their neighbours, what is left coded adaptively.
//!
//! Green is predicted by the median edge detector of LOCO-I (Weinberger, Seroussi and Sapiro 2000,
//! "The LOCO-I lossless image compression algorithm", section III.A) from the texels to the left,
//! above and between them; red and blue by the same predictor of their difference to green, which is
//! the logarithm of a ratio and mostly smooth. How large the error will be is judged by the errors
//! at the neighbours and in green, and by how much the neighbours differ.

use super::step::Step;
use crate::codec::{BitCoder, Context, Residuals, class, coarse};

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
    models: [Residuals; 3],
    /// Levels of the row above and of this one, with one more at the left and two at the right.
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

impl TileCoder {
    pub(super) fn new(step: Step) -> Self {
        Self {
            step,
            models: std::array::from_fn(|_| Residuals::new()),
            above: Vec::new(),
            row: Vec::new(),
            errors_above: Vec::new(),
            errors: Vec::new(),
            start: [step.level(START); 3],
        }
    }

    /// Codes the rows of a tile, `width` texels each. A decoder fills them in.
    pub(super) fn code(
        &mut self,
        coder: &mut impl BitCoder,
        width: usize,
        texels: &mut [[u16; 3]],
    ) {
        for rows in [&mut self.above, &mut self.row] {
            rows.clear();
            rows.resize(width + 3, self.start);
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
                self.texel(coder, x + 1, texel);
                if x == 0 && y == 0 {
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

    /// Codes the texel at `x` of the row, which has its left neighbour at `x - 1`.
    #[inline]
    fn texel(&mut self, coder: &mut impl BitCoder, x: usize, texel: &mut [u16; 3]) {
        let levels = Around {
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
        let wanted = texel.map(|bits| self.step.level(bits));
        let mut coded = [0; 3];
        // Errors of green and of the channel coded before.
        let (mut green, mut before) = (0_i32, 0_i32);
        for channel in [GREEN, RED, BLUE] {
            let near = errors.map(|e| e[channel]);
            let near = (2 * near.left + 2 * near.above + near.above_left + near.above_right) / 4;
            let plain = levels.map(|l| l[channel]);
            let (predicted, spread) = if channel == GREEN {
                (plain.predict(), plain.spread())
            } else {
                let ratio = levels.map(|l| l[channel] - l[GREEN]);
                (ratio.predict() + coded[GREEN], ratio.spread())
            };
            let predicted = predicted.clamp(0, self.step.top());
            let context = Context {
                first: (class(near), coarse(green.unsigned_abs())),
                second: (class(spread / 2), coarse(before.unsigned_abs())),
                sign: (green.signum() * 3 + before.signum() + 4) as usize,
            };
            let error = wanted[channel] - predicted;
            let error = self.models[channel].code(coder, context, error);
            coded[channel] = (predicted + error).clamp(0, self.step.top());
            self.errors[x][channel] = error.unsigned_abs();
            before = error;
            if channel == GREEN {
                green = error;
            }
        }
        self.row[x] = coded;
        *texel = coded.map(|level| self.step.bits(level));
    }
}
