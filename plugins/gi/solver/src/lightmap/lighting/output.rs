//! What is shown of a solution.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

use super::{Lighting, luminance, median};
use crate::lightmap::{patches::Receiver, raster::MeshTexels};

/// Texels that a filtered one looks at in each direction.
const RADIUS: i64 = 2;
/// Below this part of a value its standard error is not worth filtering.
const QUIET: f32 = 0.004;
/// Above this part of a value, the median around it says what is alike, not the value itself.
const NOISY: f32 = 0.05;
/// Values are mixed while they differ by less than about this many standard errors.
const EDGE: f32 = 2.0;
/// A new value that is more than this many standard errors off is believed.
const CONTRADICTION: f32 = 3.0;
/// Square of the relative error that nothing here measures: further bounces go through patches of
/// finite size. Texels of 25 cm cost about 0.7 % in empty rooms of 4 m, of 20 cm about 2 % among furniture.
const UNSEEN: f32 = 1e-4;
/// Normals of texels that are mixed have at least this cosine between them.
const ALIKE: f32 = 0.9;

impl Lighting {
    /// Blends kept and other rays and filters what is noisy.
    pub(super) fn finish(&mut self) {
        let kept = self.kept_rays();
        let raw: Vec<Vec3> = (0..self.patches.fronts).map(|i| self.blend(i, kept)).collect();
        let noisy = Noisy {
            raw: &raw,
            spread: &self.spread,
            valid: &self.valid,
            normals: &self.patches.normal,
        };
        for receiver in &self.patches.receivers {
            let first = receiver.first as usize;
            let range = first..first + receiver.texels.len();
            self.irradiance[range.clone()]
                .par_iter_mut()
                .zip(&mut self.error[range])
                .with_min_len(64)
                .enumerate()
                .for_each(|(i, out)| {
                    (*out.0, *out.1) = noisy.filtered(receiver, i);
                });
        }
        self.hold();
    }

    /// After geometry changed, keeps what was known about a texel before while it is the better known
    /// and the new value does not contradict it.
    fn hold(&mut self) {
        for (i, (old, old_error)) in self.held.iter().enumerate() {
            let error = self.error[i];
            let both = (error * error + old_error * old_error).sqrt();
            let differs = luminance((self.irradiance[i] - *old).abs());
            if *old_error < error && differs < CONTRADICTION * both {
                self.irradiance[i] = *old;
                self.error[i] = *old_error;
            }
        }
    }

    /// A receiver's padded rectangle of E / pi.
    pub(crate) fn rectangle(&self, receiver: usize) -> Vec<Vec3> {
        let plan = &self.plans[receiver];
        let first = self.patches.receivers[receiver].first as usize;
        let mut texels = vec![Vec3::ZERO; (plan.width * plan.height) as usize];
        for (i, &at) in plan.place.iter().enumerate() {
            texels[at as usize] = self.irradiance[first + i] / PI;
        }
        plan.apply(&mut texels);
        texels
    }

    /// Median over lit texels of the relative error: noise as rays that disagree tell it, and what
    /// patches of finite size cost as far as it was measured.
    pub(crate) fn relative_error(&self) -> f32 {
        /// Median of the magnitude of a normally distributed number.
        const MEDIAN: f32 = 0.674_5;
        let brightest = self.irradiance.iter().map(|e| luminance(*e)).fold(0.0, f32::max);
        let mut variances: Vec<f32> = (0..self.patches.fronts)
            .map(|i| (luminance(self.irradiance[i]), self.error[i], self.valid[i]))
            .filter(|(e, _, valid)| *valid && *e > brightest * 0.01)
            .map(|(e, error, _)| (error / e).powi(2))
            .collect();
        let Some(noise) = median(&mut variances) else { return 0.0 };
        // The kept rays' part of the result carries the patches' error.
        let share = self.kept_rays() as f32 / self.rays().max(1) as f32;
        (noise + self.refined.model_error * share * share + UNSEEN).sqrt() * MEDIAN
    }
}

/// What the filter works on, for all texels.
struct Noisy<'a> {
    raw: &'a [Vec3],
    spread: &'a [f32],
    valid: &'a [bool],
    normals: &'a [Vec3],
}

impl Noisy<'_> {
    /// A texel's value and standard error from its own and its neighbours' noisy ones. Only texels of
    /// the same chart that face the same way and do not differ by more than noise explains are mixed,
    /// so the filter fades away as the noise does.
    fn filtered(&self, receiver: &Receiver, texel: usize) -> (Vec3, f32) {
        let Self { raw, spread, valid, normals } = *self;
        let first = receiver.first as usize;
        let (own, normal) = (raw[first + texel], normals[first + texel]);
        let around = || {
            neighbours(&receiver.texels, texel)
                .filter(move |(_, i)| valid[first + i] && normals[first + i].dot(normal) > ALIKE)
        };
        // Few differences make a poor estimate of a variance: that of the neighbourhood is taken.
        let (mut sum, mut count) = (0.0, 0.0);
        for (_, other) in around() {
            sum += spread[first + other].powi(2);
            count += 1.0;
        }
        let variance: f32 = if count > 0.0 { sum / count } else { spread[first + texel].powi(2) };
        let mut level = luminance(own);
        if !valid[first + texel] || variance.sqrt() <= QUIET * level {
            return (own, variance.sqrt());
        }
        if variance.sqrt() > NOISY * level {
            // A texel whose few rays happened to find a small bright spot must not vouch for itself.
            let mut near: Vec<f32> = around()
                .filter(|(d, _)| *d <= 2.0)
                .map(|(_, i)| luminance(raw[first + i]))
                .collect();
            level = median(&mut near).unwrap_or(level);
        }
        let (mut total, mut weights, mut squares) = (Vec3::ZERO, 0.0, 0.0);
        for (distance, other) in around() {
            let value = raw[first + other];
            let difference = luminance(value) - level;
            let unlike = difference * difference / (2.0 * EDGE * EDGE * variance);
            let weight = (-unlike - distance * 0.25).exp();
            total += value * weight;
            weights += weight;
            squares += weight * weight;
        }
        if weights < 1e-6 {
            return (own, variance.sqrt());
        }
        // Independent noise would fall with the square root of that; neighbours that are chosen because
        // they are alike, and that really differ a little, help less.
        (total / weights, (variance.sqrt() * (squares.sqrt() / weights).sqrt()))
    }
}

/// Texels of the same chart around a texel and it itself, with their squared distances.
fn neighbours(texels: &MeshTexels, texel: usize) -> impl Iterator<Item = (f32, usize)> + '_ {
    let [x, y] = texels.coords[texel].map(i64::from);
    let chart = texels.chart[texel];
    (-RADIUS..=RADIUS).flat_map(move |dy| {
        (-RADIUS..=RADIUS).filter_map(move |dx| {
            let other = texels.at(x + dx, y + dy, chart)?;
            Some(((dx * dx + dy * dy) as f32, other as usize))
        })
    })
}
