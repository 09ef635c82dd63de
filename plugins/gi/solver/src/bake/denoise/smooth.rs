//! Adaptive smoothing: neighbourhoods grow as long as values agree.

use glam::Vec3;

use super::{
    Halves,
    fit::{Sample, fit},
    surface::Surface,
};

/// Radii in texels of the neighbourhoods.
const RADII: [f32; 5] = [1.5, 2.5, 4.5, 7.5, 12.0];
/// Up to this radius in texels light is taken as linear, beyond as quadratic.
const LINEAR: f32 = 3.0;
/// Texels that differ by more standard deviations don't mix.
const SIGMAS: f32 = 4.0;
/// Texels that agree with less than this share of their neighbours are noise, unless they differ by
/// [`LONE_SIGMAS`] / [`SIGMAS`] more.
const LONE: f32 = 0.1;
const LONE_SIGMAS: f32 = 16.0;

/// An estimate of a texel and its variance.
#[derive(Clone, Copy, Default)]
struct Estimate {
    value: Vec3,
    variance: Vec3,
}

/// Smooths both halves, each guided by what is known of the other; `variance` is that of one half.
pub(super) fn smooth(surface: &Surface, halves: &Halves, variance: &[Vec3]) -> Halves {
    let raw = |half: &Vec<Vec3>| -> Vec<Estimate> {
        half.iter().zip(variance).map(|(&value, &variance)| Estimate { value, variance }).collect()
    };
    let mut estimates = [raw(&halves[0]), raw(&halves[1])];
    let tolerances = [tolerances(surface, &estimates[0]), tolerances(surface, &estimates[1])];
    for radius in RADII {
        let guides = [0, 1].map(|half| {
            let tolerances = &tolerances[half];
            let guide = estimates[half].iter().zip(tolerances);
            guide.map(|(e, t)| Estimate { variance: e.variance * *t, ..*e }).collect::<Vec<_>>()
        });
        let next: Vec<[Estimate; 2]> = surface.each(radius, |i, near| {
            let mut samples = Vec::with_capacity(near.len());
            [0, 1].map(|half| {
                let guide = &guides[1 - half];
                samples.clear();
                samples.extend(near.iter().filter_map(|n| {
                    let j = n.texel as usize;
                    let agreement = if i == j { 1.0 } else { agreement(&guide[i], &guide[j])? };
                    Some(Sample {
                        x: n.x,
                        y: n.y,
                        weight: n.weight * agreement,
                        value: halves[half][j],
                        variance: variance[j],
                    })
                }));
                let (value, variance) =
                    if radius < LINEAR { fit::<3>(&samples) } else { fit::<6>(&samples) };
                // Where there is little to fit to, a larger neighbourhood may tell less.
                let last = estimates[half][i];
                if variance.element_sum() <= last.variance.element_sum() {
                    Estimate { value, variance }
                } else {
                    last
                }
            })
        });
        for (half, estimates) in estimates.iter_mut().enumerate() {
            *estimates = next.iter().map(|n| n[half]).collect();
        }
    }
    estimates.map(|half| half.into_iter().map(|e| e.value).collect())
}

/// How far the test lets two texels mix: 1 for equal ones, `None` for those that differ significantly.
fn agreement(a: &Estimate, b: &Estimate) -> Option<f32> {
    let difference = a.value - b.value;
    let limit = (a.variance + b.variance) * (SIGMAS * SIGMAS);
    let square = difference * difference;
    if square.cmpgt(limit).any() {
        return None;
    }
    let left = 1.0 - (square / limit.max(Vec3::splat(1e-30))).max_element();
    (left > 0.0).then_some(left * left)
}

/// By how much the variance of each texel counts more as a guide: texels that agree with none of their
/// neighbours are less certain than they seem, so that they mix with them. Lines and edges have
/// support and stay.
fn tolerances(surface: &Surface, estimates: &[Estimate]) -> Vec<f32> {
    surface.each(2.5, |i, near| {
        let (mut sum, mut agreeing) = (0.0, 0.0);
        for n in near.iter().filter(|n| n.texel as usize != i) {
            sum += n.weight;
            let agreement = agreement(&estimates[i], &estimates[n.texel as usize]);
            agreeing += n.weight * agreement.unwrap_or(0.0);
        }
        if agreeing < sum * LONE { (LONE_SIGMAS / SIGMAS).powi(2) } else { 1.0 }
    })
}
