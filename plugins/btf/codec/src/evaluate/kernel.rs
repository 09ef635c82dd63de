//! The evaluation of several queries at once, one a lane: `scalar.rs` step by step, in another order
//! where that saves work. What the eight curves over beta of a query have in common, the weights of
//! their four samples, is found once; codes become numbers after they were summed.

use super::lanes::{Float, Int, Lanes, Words};
use super::trigonometry::{atan2_upper, sin_cos};
use crate::angles::BETA_POLE;
use crate::layout::{Coded, Packed};
use crate::{Layout, Rules};

/// What all queries of a batch share.
#[derive(Clone, Copy)]
pub(super) struct Shared<'a, L: Lanes> {
    pub(super) lanes: L,
    pub(super) layout: &'a Layout,
    pub(super) words: Words<'a>,
    /// For each interval of beta: where it begins, and 1 over its length.
    pub(super) intervals: Words<'a>,
    pub(super) rules: Rules,
}

/// As `ViewSlices`.
pub(super) struct Slices<L: Lanes> {
    pub(super) luminances: [L::Int; 4],
    pub(super) chromas: [L::Int; 4],
    pub(super) weights: [L::Float; 4],
}

/// Where the light falls among the samples.
pub(super) struct Light<L: Lanes> {
    /// Lower sample of alpha, and the weights of both.
    alpha: L::Int,
    alpha_weights: [L::Float; 2],
    /// Lower sample of beta, and the weights of both.
    beta: L::Int,
    beta_weights: [L::Float; 2],
    /// Weights of the samples before, at, after and two after the lower one.
    curve: [L::Float; 4],
}

impl<L: Lanes> Shared<'_, L> {
    #[inline(always)]
    fn float(&self, value: f32) -> L::Float {
        self.lanes.float(value)
    }

    #[inline(always)]
    fn int(&self, value: u32) -> L::Int {
        self.lanes.int(value)
    }

    /// `Cell::between`: the lower sample and the weight of the upper one, `at` samples from the first.
    #[inline(always)]
    fn cell(&self, at: L::Float, count: u32) -> (L::Int, L::Float) {
        let low = at.max(self.float(0.0)).to_int().min(self.int(count - 2));
        (low, self.unit(at - low.to_float()))
    }

    #[inline(always)]
    fn unit(&self, value: L::Float) -> L::Float {
        value.max(self.float(0.0)).min(self.float(1.0))
    }

    /// `Btf::view_slices` of the texels with these numbers.
    #[inline(always)]
    pub(super) fn view(&self, texel: L::Int, theta_v: L::Float, phi_v: L::Float) -> Slices<L> {
        let layout = self.layout;
        let (azimuths, texel_scale) =
            self.packed(&layout.texels, self.word(layout.texels.offset, texel));

        let steps = (layout.theta_count - 1) as f32 / std::f32::consts::FRAC_PI_2;
        let (theta, theta_weight) = self.cell(theta_v * self.float(steps), layout.theta_count);
        let theta_weights = [self.float(1.0) - theta_weight, theta_weight];

        // The stored azimuth runs the other way round; `turn` is its part of a whole turn.
        let turn = phi_v * self.float(-1.0 / std::f32::consts::TAU);
        let turn = turn - turn.floor();
        let at = turn * self.float(layout.phi_count as f32);
        let low = at.to_int().min(self.int(layout.phi_count - 1));
        let weight = self.unit(at - low.to_float());
        let next = low + self.int(1);
        let high = self.int(0).select(next.equals(self.int(layout.phi_count)), next);

        let row = azimuths * self.int(layout.phi_count);
        let mut slices = Slices {
            luminances: [self.int(0); 4],
            chromas: [self.int(0); 4],
            weights: [self.float(0.0); 4],
        };
        let columns = [(low, self.float(1.0) - weight), (high, weight)];
        for (half, (column, phi_weight)) in columns.into_iter().enumerate() {
            let word = self.word(layout.azimuths.offset, row + column);
            let (elevations, scale) = self.packed(&layout.azimuths, word);
            let outer = texel_scale * scale * phi_weight;
            let entry = (elevations * self.int(layout.theta_count) + theta) << 1;
            for (quarter, theta_weight) in theta_weights.into_iter().enumerate() {
                let at = entry + self.int(layout.elevations.offset + 2 * quarter as u32);
                let [word, chromas] = self.lanes.pair(self.words, at);
                let (luminances, scale) = self.packed(&layout.elevations, word);
                let at = 2 * half + quarter;
                slices.luminances[at] = luminances;
                slices.chromas[at] = chromas;
                slices.weights[at] = outer * scale * theta_weight;
            }
        }
        slices
    }

    /// `SliceAngles::new`, then [`Shared::light`].
    #[inline(always)]
    pub(super) fn light_of_angles(&self, theta_i: L::Float, difference: L::Float) -> Light<L> {
        let (sin_theta, cos_theta) = sin_cos(self.lanes, theta_i);
        let (sin, cos) = sin_cos(self.lanes, difference);
        let zero = self.float(0.0);
        let across = zero - sin * sin_theta;
        let mirror = zero - cos * sin_theta;
        let up = cos_theta.max(zero);
        let cos_beta = mirror.mul_add(mirror, up * up).sqrt();
        let beta = atan2_upper(self.lanes, across, cos_beta);
        let alpha = atan2_upper(self.lanes, mirror, up);
        let pole = if self.rules.guard_beta_pole { BETA_POLE } else { f32::MIN_POSITIVE };
        let alpha = zero.select(cos_beta.less(self.float(pole)), alpha);
        self.light(alpha, beta, across)
    }

    /// The cells of alpha and beta and the weights in them.
    #[inline(always)]
    pub(super) fn light(&self, alpha: L::Float, beta: L::Float, sin_beta: L::Float) -> Light<L> {
        let layout = self.layout;
        let one = self.float(1.0);
        let half_turn = self.float(std::f32::consts::FRAC_PI_2);
        let steps = |count: u32| self.float((count - 1) as f32 / std::f32::consts::PI);
        let at = (alpha + half_turn) * steps(layout.alpha_count);
        let (alpha, weight) = self.cell(at, layout.alpha_count);

        let at = if layout.flags & Layout::BETA_IN_SINE != 0 {
            (sin_beta + one) * self.float((layout.beta_count - 1) as f32 * 0.5)
        } else {
            (beta + half_turn) * steps(layout.beta_count)
        };
        let (low, _) = self.cell(at, layout.beta_count);
        let [from, per_length] = self.lanes.pair(self.intervals, low << 1);
        let t = self.unit((beta - from.as_float()) * per_length.as_float());
        Light {
            alpha,
            alpha_weights: [one - weight, weight],
            beta: low,
            beta_weights: [one - t, t],
            curve: self.curve(low, t),
        }
    }

    /// The Hermite interpolation of `Btf::shape` as weights of its samples.
    #[inline(always)]
    fn curve(&self, low: L::Int, t: L::Float) -> [L::Float; 4] {
        let (zero, half, one) = (self.float(0.0), self.float(0.5), self.float(1.0));
        let first = low.equals(self.int(0));
        let last = low.equals(self.int(self.layout.beta_count - 2));
        let rest = one - t;
        // The Hermite polynomials of the upper value and of the slopes.
        let upper = t * t * (self.float(3.0) - t - t);
        let start = t * rest * rest;
        let end = zero - t * t * rest;
        // Start slope: half of the way from the sample before to the upper one, or, in the first
        // interval, the rise from the lower to the upper one.
        let start_upper = start * one.select(first, half);
        let start_lower = start.select(first, zero);
        let start_before = start_upper - start_lower;
        // End slope: half of the way from the lower sample to the one two after it, or a part of the
        // rise: all of it in the last interval, half of it by the rule.
        let half_rise = self.rules.half_end_slope;
        let end_upper = end * one.select(last, if half_rise { half } else { zero });
        let end_after = end * zero.select(last, if half_rise { zero } else { half });
        let lower = one - upper - start_lower - end_upper - end_after;
        [zero - start_before, lower, upper + start_upper + end_upper, end_after]
    }

    /// `Btf::evaluate_slices`, for video luma and chroma.
    #[inline(always)]
    pub(super) fn value(&self, slices: &Slices<L>, light: &Light<L>) -> [L::Float; 3] {
        let zero = self.float(0.0);
        let mut sum = [zero; 3];
        for slice in 0..4 {
            let luma = self.luminance(slices.luminances[slice], light) * self.float(1.164_382_8);
            let [first, second] = self.chroma(slices.chromas[slice], light);
            let red = second.mul_add(self.float(1.596_027_3), luma + self.float(-222.921));
            let green = first.mul_add(self.float(-0.391_761_72), luma + self.float(135.576));
            let green = second.mul_add(self.float(-0.812_968_75), green);
            let blue = first.mul_add(self.float(2.017_234_4), luma + self.float(-276.836));
            for (sum, channel) in sum.iter_mut().zip([red, green, blue]) {
                *sum = channel.max(zero).mul_add(slices.weights[slice], *sum);
            }
        }
        sum
    }

    #[inline(always)]
    fn luminance(&self, row: L::Int, light: &Light<L>) -> L::Float {
        let layout = self.layout;
        let at = row * self.int(layout.alpha_count) + light.alpha;
        let entries = self.lanes.pair(self.words, at + self.int(layout.luminances.offset));
        let mut sum = self.float(0.0);
        for (word, weight) in entries.into_iter().zip(light.alpha_weights) {
            let (shape, scale) = self.packed(&layout.luminances, word);
            sum = (scale * weight).mul_add(self.shape(&layout.shapes, shape, light), sum);
        }
        sum
    }

    /// The sample before the first belongs to another row, and gets the weight 0.
    #[inline(always)]
    fn shape(&self, table: &Coded, row: L::Int, light: &Light<L>) -> L::Float {
        let at = row * self.int(2 * table.stride) + light.beta;
        let at = at + self.int((2 * table.offset).wrapping_sub(1));
        let [lower, upper] = self.lanes.pair_at_half(self.words, at);
        let [before, at] = self.halves(lower);
        let [next, after] = self.halves(upper);
        let sum = before * light.curve[0];
        let sum = at.mul_add(light.curve[1], sum);
        let sum = next.mul_add(light.curve[2], sum);
        let sum = after.mul_add(light.curve[3], sum);
        sum.mul_add(self.float(table.step), self.float(table.min))
    }

    #[inline(always)]
    fn chroma(&self, row: L::Int, light: &Light<L>) -> [L::Float; 2] {
        let layout = self.layout;
        let table = &layout.colour_rows;
        let at = row * self.int(layout.alpha_count) + light.alpha;
        let rows = self.lanes.pair(self.words, at + self.int(layout.chromas));
        let mut sum = [self.float(0.0); 2];
        for (row, alpha_weight) in rows.into_iter().zip(light.alpha_weights) {
            let at = row * self.int(table.stride) + light.beta + self.int(table.offset);
            let codes = self.lanes.pair(self.words, at);
            for (codes, beta_weight) in codes.into_iter().zip(light.beta_weights) {
                let weight = alpha_weight * beta_weight;
                for (sum, code) in sum.iter_mut().zip(self.halves(codes)) {
                    *sum = code.mul_add(weight, *sum);
                }
            }
        }
        sum.map(|sum| sum.mul_add(self.float(table.step), self.float(table.min)))
    }

    #[inline(always)]
    fn halves(&self, word: L::Int) -> [L::Float; 2] {
        [(word & self.int(0xffff)).to_float(), (word >> 16).to_float()]
    }

    #[inline(always)]
    fn word(&self, offset: u32, at: L::Int) -> L::Int {
        self.lanes.word(self.words, at + self.int(offset))
    }

    /// Index and factor of an entry.
    #[inline(always)]
    fn packed(&self, table: &Packed, word: L::Int) -> (L::Int, L::Float) {
        let code = (word >> table.index_bits).to_float();
        let index = word & self.int((1 << table.index_bits) - 1);
        (index, code.mul_add(self.float(table.step), self.float(table.min)))
    }
}
