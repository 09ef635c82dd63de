//! Probes: nine coefficients, each a multiple of a step that follows from the first one.
//!
//! The error of a coefficient matters beside the first one (L0, the mean radiance), so the step is
//! the power of two between 1/1024 and 1/512 of it, and the error at most 1/1024 (where texels are
//! sent less exactly, twice or four times as much). L0 itself is coded like a texel. What the others are beside it is predicted from the neighbours along x, y and
//! z that are already there, and in red and blue also from how far that was off in green. Where the
//! other side has an older state of the run, it is that state and how the neighbours have changed
//! since.

use glam::UVec3;
use half::f16;

use super::{
    octave::{half_of, log_of},
    step::{LARGEST, Step},
};
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
    exactness: Step,
    /// For probes by themselves and for those beside others.
    means: [[Residuals; 3]; 2],
    coefficients: [[Residuals; 3]; 2],
    doublings: Residuals,
    signs: Residuals,
    /// The last probe of the run before.
    last: Probe,
    /// How large the errors were in the probe before.
    errors: [[u32; 3]; 9],
}

/// What the neighbours let one expect.
struct Expected {
    /// Level of L0.
    means: [i32; 3],
    /// The others in units of L0; the first is not used.
    shape: [[f32; 3]; 9],
}

impl Expected {
    /// The mean of neighbours, of which there is at least one.
    fn mean_of(neighbours: &[&Probe], exactness: Step) -> Self {
        let (mut means, mut shape) = ([0; 3], [[0.0; 3]; 9]);
        for probe in neighbours {
            for channel in 0..3 {
                means[channel] += exactness.level(probe[0][channel] & 0x7fff);
                let mean = value(probe[0][channel]);
                if mean != 0.0 {
                    for i in 1..9 {
                        shape[i][channel] += value(probe[i][channel]) / mean;
                    }
                }
            }
        }
        let count = neighbours.len() as i32;
        let shape = shape.map(|c| c.map(|sum| sum / count as f32));
        Self { means: means.map(|sum| sum / count), shape }
    }
}

/// What a probe should be beside an older state of it, if neighbours have changed alike. `now` and
/// `then` are the same neighbours.
fn grown(old: &Probe, now: &[&Probe], then: &[&Probe], exactness: Step) -> Expected {
    let mut expected = Expected::mean_of(&[old], exactness);
    if now.is_empty() {
        return expected;
    }
    let (after, before) = (Expected::mean_of(now, exactness), Expected::mean_of(then, exactness));
    let log = |bits: u16| log_of(bits & 0x7fff);
    for channel in 0..3 {
        let growth = |(now, then): (&&Probe, &&Probe)| log(now[0][channel]) - log(then[0][channel]);
        let growth = now.iter().zip(then).map(growth).sum::<i32>() / now.len() as i32;
        expected.means[channel] = exactness.level(half_of(log(old[0][channel]) + growth));
        for i in 1..9 {
            expected.shape[i][channel] += after.shape[i][channel] - before.shape[i][channel];
        }
    }
    expected
}

/// Whether a run of probes is nearer to an older state than each of its probes to the one before it:
/// by the coefficients of green beside their mean.
pub(super) fn is_smoother_beside(values: &[[u16; 3]], base: &[[u16; 3]]) -> bool {
    let shape = |probe: &Probe, i: usize| {
        let mean = value(probe[0][GREEN]);
        if mean == 0.0 { 0.0 } else { value(probe[i][GREEN]) / mean }
    };
    let distance = |a: &Probe, b: &Probe| {
        let means = log_of(a[0][GREEN] & 0x7fff).abs_diff(log_of(b[0][GREEN] & 0x7fff));
        let shapes = (1..9).map(|i| (shape(a, i) - shape(b, i)).abs()).sum::<f32>();
        means as f32 / 1024.0 + shapes
    };
    let (probes, olds) = (values.as_chunks().0, base.as_chunks().0);
    let alone: f32 = probes.windows(2).map(|pair| distance(&pair[1], &pair[0])).sum();
    let beside: f32 = probes.iter().zip(olds).skip(1).map(|(a, b)| distance(a, b)).sum();
    beside <= alone
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
    pub(super) fn new(exactness: Step) -> Self {
        Self {
            exactness,
            means: std::array::from_fn(|_| std::array::from_fn(|_| Residuals::new())),
            coefficients: std::array::from_fn(|_| std::array::from_fn(|_| Residuals::new())),
            doublings: Residuals::new(),
            signs: Residuals::new(),
            last: [[0x3400; 3]; 9],
            errors: [[8; 3]; 9],
        }
    }

    /// Codes a run of probes that begins at `first` in a grid, as they are or beside an older state. A
    /// decoder fills them in.
    pub(super) fn code(
        &mut self,
        coder: &mut impl BitCoder,
        resolution: UVec3,
        first: u32,
        probes: &mut [Probe],
        base: Option<&[Probe]>,
    ) {
        let kind = usize::from(base.is_some());
        let (row, layer) = (resolution.x as usize, resolution.x as usize * resolution.y as usize);
        for at in 0..probes.len() {
            let (there, rest) = probes.split_at_mut(at);
            let index = first as usize + at;
            let along = [(index % row, 1), (index % layer / row, row), (index / layer, layer)];
            let (mut places, mut count) = ([0; 3], 0);
            for (place, stride) in along {
                if let Some(neighbour) = at.checked_sub(stride).filter(|_| place > 0) {
                    places[count] = neighbour;
                    count += 1;
                }
            }
            if count == 0 && at > 0 {
                places[0] = at - 1;
                count = 1;
            }
            let neighbours = places.map(|place| there.get(place).unwrap_or(&self.last));
            let expected = match base {
                None => Expected::mean_of(&neighbours[..count.max(1)], self.exactness),
                // Whoever lacks the base codes beside black, and throws the run away.
                Some(base) => {
                    let old = |place: usize| base.get(place).unwrap_or(&[[0; 3]; 9]);
                    let then = places.map(old);
                    grown(old(at), &neighbours[..count], &then[..count], self.exactness)
                }
            };
            self.probe(coder, kind, &expected, &mut rest[0]);
        }
        if base.is_none() {
            self.last = probes.last().copied().unwrap_or(self.last);
        }
    }

    fn probe(
        &mut self,
        coder: &mut impl BitCoder,
        kind: usize,
        expected: &Expected,
        probe: &mut Probe,
    ) {
        // How far green was off: in levels of L0, in units of L0, in steps. Contexts know only the
        // errors that were coded, which a reader without the base knows too.
        let (mut off_mean, mut off, mut off_steps) = (0, [0.0; 9], [0_u32; 9]);
        for channel in [GREEN, RED, BLUE] {
            let predicted = expected.means[channel];
            let missed =
                self.mean(coder, kind, channel, predicted, off_mean, &mut probe[0][channel]);
            let step = self.step(coder, channel, probe);
            let steps = value(probe[0][channel]) / step;
            let mut before = 0;
            for i in 1..9 {
                let shape = expected.shape[i][channel] + off[i];
                let predicted = (shape * steps).clamp(-MOST, MOST).round();
                let wanted = (value(probe[i][channel]) / step).clamp(-MOST, MOST).round();
                let near = (2 * self.errors[i][channel] + before) / 3;
                let context = Context {
                    first: (class(near), coarse(off_steps[i])),
                    second: (class(before), (i - 1) / 3),
                    sign: 0,
                };
                let error = wanted as i32 - predicted as i32;
                let error = self.coefficients[kind][channel].code(coder, context, error);
                let coded = (predicted + error as f32).clamp(-MOST, MOST) * step;
                probe[i][channel] = bits(coded);
                before = error.unsigned_abs();
                self.errors[i][channel] = before;
                if channel == GREEN {
                    off_steps[i] = before;
                }
                if channel == GREEN && steps != 0.0 {
                    off[i] = value(probe[i][channel]) / (steps * step) - expected.shape[i][channel];
                }
            }
            if channel == GREEN {
                off_mean = missed;
            }
        }
    }

    /// L0; returns the error that was coded.
    fn mean(
        &mut self,
        coder: &mut impl BitCoder,
        kind: usize,
        channel: usize,
        predicted: i32,
        green: i32,
        mean: &mut u16,
    ) -> i32 {
        let step = self.exactness;
        let wanted = value(*mean);
        let negative = self.signs.code(coder, sized(0), i32::from(wanted < 0.0)) != 0;
        let level = step.level(bits(wanted.abs()));
        let corrected = (predicted + green).clamp(0, step.top());
        let near = self.errors[0][channel];
        let context = Context {
            first: (class(near), coarse(green.unsigned_abs())),
            second: (class(green.unsigned_abs()), 0),
            sign: (green.signum() + 1) as usize,
        };
        let error = self.means[kind][channel].code(coder, context, level - corrected);
        self.errors[0][channel] = error.unsigned_abs();
        let level = (corrected + error).clamp(0, step.top());
        let size = f16::from_bits(step.bits(level)).to_f32();
        *mean = bits(if negative { -size } else { size });
        error
    }

    /// The step of a channel whose L0 is coded. It is doubled where other coefficients are larger
    /// than those of real light.
    fn step(&mut self, coder: &mut impl BitCoder, channel: usize, probe: &Probe) -> f32 {
        let exponent = i32::from(probe[0][channel] >> 10 & 0x1f).max(1) - 15 - SIGNIFICANT
            + self.exactness.units().ilog2() as i32;
        let largest = probe[1..].iter().map(|c| value(c[channel]).abs()).fold(0.0, f32::max);
        let fits = |doublings: &i32| (largest / power(exponent + doublings)).round() <= MOST;
        let doublings = (0..=DOUBLINGS).find(fits).unwrap_or(DOUBLINGS);
        let doublings = self.doublings.code(coder, sized(0), doublings);
        power(exponent + doublings.clamp(0, DOUBLINGS))
    }
}
