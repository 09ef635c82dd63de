//! How noisy texels are, and which are noise alone.

use glam::Vec3;

use super::{Halves, surface::Surface};

/// Radius in texels over which variances are averaged.
const RADIUS: f32 = 2.5;
/// The mean squared difference of smoothed from raw texels, in units of their variance, that may be chance.
const TOLERATED: f32 = 1.8;
/// The radius in texels over which it is taken.
const RESTORED: f32 = 3.5;
/// No single texel counts more.
const MOST: f32 = 20.0;
/// A texel whose halves differ by more than so many times what its neighbours' do is an outlier.
const OUTLIER: f32 = 8.0;
/// Radius in texels over which an outlier's excess is spread.
const SPREAD: f32 = 5.0;

/// Variance of each half's values, the mean over neighbours.
pub(super) fn variance(surface: &Surface, halves: &Halves) -> Vec<Vec3> {
    let squares = differences(halves, |d| d * d * 0.5);
    surface.each(RADIUS, |_, near| {
        let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
        for n in near {
            sum += squares[n.texel as usize] * n.weight;
            weight += n.weight;
        }
        sum / weight
    })
}

fn differences(halves: &Halves, f: impl Fn(Vec3) -> Vec3) -> Vec<Vec3> {
    halves[0].iter().zip(&halves[1]).map(|(a, b)| f(*a - *b)).collect()
}

/// Goes back from `smooth` to `raw` where the two differ by more than noise explains: there smoothing has
/// gone too far. `variance` is that of a half.
pub(super) fn restore(surface: &Surface, raw: &[Vec3], smooth: &mut [Vec3], variance: &[Vec3]) {
    let squares: Vec<Vec3> = raw
        .iter()
        .zip(smooth.iter())
        .zip(variance)
        .map(|((raw, smooth), variance)| {
            let difference = *raw - *smooth;
            (difference * difference).min(*variance * (0.5 * MOST))
        })
        .collect();
    let shares: Vec<Vec3> = surface.each(RESTORED, |_, near| {
        let (mut square, mut expected) = (Vec3::ZERO, Vec3::splat(1e-30));
        for n in near {
            square += squares[n.texel as usize] * n.weight;
            expected += variance[n.texel as usize] * (0.5 * n.weight);
        }
        (expected * TOLERATED / square.max(expected * TOLERATED)).min(Vec3::ONE)
    });
    for i in (0..raw.len()).filter(|&i| surface.is_usable(i)) {
        smooth[i] = raw[i] + (smooth[i] - raw[i]) * shares[i];
    }
}

/// Clamps lone outliers and gives what is taken from them to their neighbours, in proportion to the light
/// that these have, so that none is lost. What both halves agree on is not an outlier.
pub(super) fn clamp_outliers(surface: &Surface, halves: &mut Halves) {
    let size = differences(halves, |d| d.abs());
    // The mean size of the neighbours' differences.
    let usual: Vec<Vec3> = surface.each(RADIUS, |i, near| {
        let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
        for n in near.iter().filter(|n| n.texel as usize != i) {
            sum += size[n.texel as usize] * n.weight;
            weight += n.weight;
        }
        // Alone, it has nobody to compare with.
        if weight > 1.0 { sum / weight } else { Vec3::INFINITY }
    });
    let mut excess = [0, 1].map(|_| vec![Vec3::ZERO; surface.len()]);
    let mut any = false;
    for i in (0..surface.len()).filter(|&i| surface.is_usable(i)) {
        let over = (size[i] - usual[i] * OUTLIER).max(Vec3::ZERO);
        if over != Vec3::ZERO {
            for (half, sign) in [(0, 1.0), (1, -1.0)] {
                // The half that has more is the one that is wrong.
                let more = (halves[0][i] - halves[1][i]) * sign;
                excess[half][i] = Vec3::select(more.cmpgt(Vec3::ZERO), over, Vec3::ZERO);
                halves[half][i] -= excess[half][i];
            }
            any = true;
        }
    }
    if !any {
        return;
    }
    let light: Vec<Vec3> = surface.each(RADIUS, |_, near| {
        let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
        for n in near {
            sum += (halves[0][n.texel as usize] + halves[1][n.texel as usize]) * n.weight;
            weight += n.weight;
        }
        (sum / weight).max(Vec3::splat(1e-9))
    });
    let sums: Vec<Vec3> = surface.each(SPREAD, |_, near| {
        near.iter().map(|n| light[n.texel as usize] * n.weight).sum::<Vec3>()
    });
    for (half, excess) in halves.iter_mut().zip(&excess) {
        let gifts: Vec<Vec3> = surface.each(SPREAD, |i, near| {
            let from = near.iter().filter(|n| excess[n.texel as usize] != Vec3::ZERO);
            from.map(|n| excess[n.texel as usize] / sums[n.texel as usize] * light[i] * n.weight)
                .sum::<Vec3>()
        });
        for (value, gift) in half.iter_mut().zip(gifts) {
            *value += gift;
        }
    }
}
