//! Probes: nine coefficients, each a multiple of a step that follows from the first one.
//!
//! The error of a coefficient matters beside the first one (L0, the mean radiance), so the step is
//! the power of two between 1/1024 and 1/512 of it, and the error at most 1/1024. L0 itself is
//! coded like a texel. Values are predicted from the probe before, and in red and blue also by how
//! far green was off.

use half::f16;

use super::step::{LARGEST, Step};
use crate::codec::{BitCoder, Context, Residuals, class, coarse};

const RED: usize = 0;
const GREEN: usize = 1;
const BLUE: usize = 2;

/// A half has 11 significant bits; two fewer make 1/512.
const SIGNIFICANT: i32 = 9;
/// Multiples of the step are at most so large. Real ones are smaller: a coefficient of radiance
/// that is nowhere negative is at most √5 L0, 2300 steps. Of 11 significant bits, so that no half
/// next to a multiple lies beyond it.
const MOST: f32 = 4094.0;
/// Doublings of the step that are possible: from the smallest half to the largest.
const DOUBLINGS: i32 = 31;

/// One probe.
pub(super) type Probe = [[u16; 3]; 9];

/// Learns over all probes of a message.
#[derive(Debug)]
pub(super) struct ProbeCoder {
    means: [Residuals; 3],
    coefficients: [Residuals; 3],
    doublings: Residuals,
    signs: Residuals,
    /// The probe before.
    last: Probe,
    /// How large the errors were there.
    errors: [[u32; 3]; 9],
}

/// For L0, always the finest.
fn step() -> Step {
    Step::of(&farlight_gi_solver::session::Quality::default())
}

/// The finite value of a half's bits.
fn value(bits: u16) -> f32 {
    let value = f16::from_bits(bits).to_f32();
    if value.is_finite() { value } else { 0.0 }
}

/// The bits of the half next to a value.
fn bits(value: f32) -> u16 {
    let largest = f16::from_bits(LARGEST).to_f32();
    // A sum clears the sign of -0.
    f16::from_f32(value.clamp(-largest, largest) + 0.0).to_bits()
}

/// `2^exponent` of a normal number.
fn power(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

fn sized(size: u32) -> Context {
    Context { first: (class(size), 0), second: (class(size), 0), sign: 0 }
}

impl ProbeCoder {
    pub(super) fn new() -> Self {
        Self {
            means: std::array::from_fn(|_| Residuals::new()),
            coefficients: std::array::from_fn(|_| Residuals::new()),
            doublings: Residuals::new(),
            signs: Residuals::new(),
            last: [[0x3400; 3]; 9],
            errors: [[8; 3]; 9],
        }
    }

    /// Codes a probe. A decoder fills it in.
    pub(super) fn code(&mut self, coder: &mut impl BitCoder, probe: &mut Probe) {
        // How far green was off: in levels of L0, then as values.
        let mut off_mean = 0;
        let mut off = [0.0; 9];
        for channel in [GREEN, RED, BLUE] {
            let error = self.mean(coder, channel, off_mean, &mut probe[0][channel]);
            if channel == GREEN {
                off_mean = error;
            }
            let ratio = match (value(probe[0][channel]), value(probe[0][GREEN])) {
                _ if channel == GREEN => 0.0,
                (_, 0.0) => 1.0,
                (own, green) => (own / green).clamp(-16.0, 16.0),
            };
            let step = self.step(coder, channel, probe);
            let mut before = 0;
            for i in 1..9 {
                let predicted = value(self.last[i][channel]) + off[i] * ratio;
                let predicted = (predicted / step).clamp(-MOST, MOST).round();
                let wanted = (value(probe[i][channel]) / step).clamp(-MOST, MOST).round();
                let near = (2 * self.errors[i][channel] + before) / 3;
                let context = Context {
                    first: (class(near), coarse((off[i] * ratio / step).abs() as u32)),
                    second: (class(before), (i - 1) / 3),
                    sign: 0,
                };
                let error = wanted as i32 - predicted as i32;
                let error = self.coefficients[channel].code(coder, context, error);
                let coded = (predicted + error as f32).clamp(-MOST, MOST) * step;
                probe[i][channel] = bits(coded);
                if channel == GREEN {
                    off[i] = value(probe[i][channel]) - value(self.last[i][channel]);
                }
                before = error.unsigned_abs();
                self.errors[i][channel] = before;
            }
        }
        self.last = *probe;
    }

    /// L0; returns by how many levels the prediction was off.
    fn mean(
        &mut self,
        coder: &mut impl BitCoder,
        channel: usize,
        green: i32,
        mean: &mut u16,
    ) -> i32 {
        let step = step();
        let last = self.last[0][channel];
        let wanted = value(*mean);
        let negative = self.signs.code(coder, sized(0), i32::from(wanted < 0.0)) != 0;
        let level = step.level(bits(wanted.abs()));
        let predicted = (step.level(last & 0x7fff) + green).clamp(0, step.top());
        let near = self.errors[0][channel];
        let context = Context {
            first: (class(near), coarse(green.unsigned_abs())),
            second: (class(green.unsigned_abs()), 0),
            sign: (green.signum() + 1) as usize,
        };
        let error = self.means[channel].code(coder, context, level - predicted);
        self.errors[0][channel] = error.unsigned_abs();
        let level = (predicted + error).clamp(0, step.top());
        let size = f16::from_bits(step.bits(level)).to_f32();
        *mean = bits(if negative { -size } else { size });
        level - step.level(last & 0x7fff)
    }

    /// The step of a channel whose L0 is coded. It is doubled where other coefficients are larger
    /// than those of real light.
    fn step(&mut self, coder: &mut impl BitCoder, channel: usize, probe: &Probe) -> f32 {
        let exponent = i32::from(probe[0][channel] >> 10 & 0x1f).max(1) - 15 - SIGNIFICANT;
        let largest = probe[1..].iter().map(|c| value(c[channel]).abs()).fold(0.0, f32::max);
        let fits = |doublings: &i32| (largest / power(exponent + doublings)).round() <= MOST;
        let doublings = (0..=DOUBLINGS).find(fits).unwrap_or(DOUBLINGS);
        let doublings = self.doublings.code(coder, sized(0), doublings);
        power(exponent + doublings.clamp(0, DOUBLINGS))
    }
}
