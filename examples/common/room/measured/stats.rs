//! The numbers of the report: errors of a lightmap against its reference, and how fast a change of
//! the light arrives.

use bevy::math::Vec3;
use serde::Serialize;

/// Texels darker than this fraction of the brightest one are left out of relative errors.
pub const ERROR_FLOOR: f32 = 0.01;
/// Receivers of a step: texels whose converged value changes by at least this fraction of the
/// largest change.
pub const RECEIVER_FLOOR: f32 = 0.1;
/// A receiver has arrived when this fraction of its change is done.
pub const ARRIVED: f32 = 0.9;

/// Smallest, middle and largest of several measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Smallest.
    pub min: f32,
    /// Middle.
    pub median: f32,
    /// Largest.
    pub max: f32,
}

impl Spread {
    /// Of some measurements; `None` of none.
    pub fn of(values: &[f32]) -> Option<Self> {
        Some(Self {
            min: quantile(values, 0.0)?,
            median: quantile(values, 0.5)?,
            max: quantile(values, 1.0)?,
        })
    }
}

/// The value below which a fraction of all values lies (nearest rank, interpolated).
pub fn quantile(values: &[f32], fraction: f32) -> Option<f32> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    let place = fraction.clamp(0.0, 1.0) * (sorted.len().checked_sub(1)?) as f32;
    let (below, above) = (sorted[place as usize], sorted[place.ceil() as usize]);
    Some(below + (above - below) * place.fract())
}

fn sum(texel: Vec3) -> f32 {
    texel.element_sum()
}

/// Relative error of each texel that is at least [`ERROR_FLOOR`] of the brightest: the absolute
/// differences of the channels, summed, over the reference's channels, summed.
pub fn relative_errors(live: &[Vec3], reference: &[Vec3]) -> Vec<f32> {
    compared(reference)
        .into_iter()
        .map(|i| sum((live[i] - reference[i]).abs()) / sum(reference[i]))
        .collect()
}

/// The texels that have a relative error: those of at least [`ERROR_FLOOR`] of the brightest.
pub fn compared(reference: &[Vec3]) -> Vec<usize> {
    let brightest = reference.iter().copied().map(sum).fold(0.0, f32::max);
    let bright =
        |i: &usize| sum(reference[*i]) > 0.0 && sum(reference[*i]) >= ERROR_FLOOR * brightest;
    (0..reference.len()).filter(bright).collect()
}

/// When a change of the light arrived; `None`: not while it was watched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StepTimes {
    /// The first texel that knows of the change was written.
    pub first_texel_ms: Option<f32>,
    /// From here on the median receiver has done [`ARRIVED`] of its own change.
    pub median_receiver_90_ms: Option<f32>,
    /// From here on 90 % of the receivers have done [`ARRIVED`] of their own change.
    pub receivers_90_ms: Option<f32>,
    /// From here on [`ARRIVED`] of the change summed over all receivers is done.
    pub sum_90_ms: Option<f32>,
    /// How many receivers there were.
    pub receivers: usize,
}

/// What the lightmap held after a write.
pub struct Written {
    /// Milliseconds from the change of the light to the write of the first texel.
    pub first_ms: f32,
    /// The same to the write of the last.
    pub at_ms: f32,
    /// Whether texels of this write know of the change.
    pub knows: bool,
    /// All texels, in the order of the references.
    pub texels: Vec<Vec3>,
}

/// Times of one step from the converged lightmaps `before` and `after` it, what was `shown` when it
/// happened, and what was written since. The change of a texel is that of its channels' sum; done is
/// what the shown value has changed since the step, so that a lasting error does not count as delay.
pub fn step_times(
    before: &[Vec3],
    after: &[Vec3],
    shown: &[Vec3],
    writes: &[Written],
) -> StepTimes {
    let change: Vec<f32> = before.iter().zip(after).map(|(b, a)| sum(*a) - sum(*b)).collect();
    let largest = change.iter().fold(0.0_f32, |m, c| m.max(c.abs()));
    let receivers: Vec<usize> = (0..change.len())
        .filter(|&i| largest > 0.0 && change[i].abs() >= RECEIVER_FLOOR * largest)
        .collect();
    let progress = |write: &Written, i: usize| (sum(write.texels[i]) - sum(shown[i])) / change[i];
    let since = |arrived: &dyn Fn(&Written) -> bool| {
        let last_late = writes.iter().rposition(|w| !arrived(w));
        let first = last_late.map_or(0, |i| i + 1);
        writes.get(first).map(|w| w.at_ms)
    };
    let share_done = |write: &Written| {
        let done = receivers.iter().filter(|&&i| progress(write, i) >= ARRIVED).count();
        done as f32 / receivers.len().max(1) as f32
    };
    let whole: f32 = receivers.iter().map(|&i| change[i].abs()).sum();
    let sum_done = |write: &Written| {
        receivers.iter().map(|&i| progress(write, i) * change[i].abs()).sum::<f32>()
            >= ARRIVED * whole
    };
    StepTimes {
        first_texel_ms: writes.iter().find(|w| w.knows).map(|w| w.first_ms),
        median_receiver_90_ms: since(&|w| share_done(w) >= 0.5),
        receivers_90_ms: since(&|w| share_done(w) >= 0.9),
        sum_90_ms: since(&sum_done),
        receivers: receivers.len(),
    }
}
