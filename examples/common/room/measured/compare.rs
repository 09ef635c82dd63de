//! What was seen, against what is true.

use std::time::Instant;

use bevy::math::Vec3;
use farlight_gi_solver::{Scene, estimate::GatherSettings, scene::Light};

use super::{
    args::Args,
    live::Moment,
    measure::{Seen, Step},
    reference::{TexelCentre, converge},
    report::{ErrorSummary, Report},
    stats::{Spread, StepTimes, Written, compared, quantile, relative_errors, step_times},
};

/// Texels at which errors are measured, evenly spread over all lit ones.
const ERROR_TEXELS: usize = 1024;

/// Computes the references and fills the report's errors and step times.
pub fn compare(
    seen: &Seen,
    shown: &Moment,
    centres: &[TexelCentre],
    args: &Args,
    report: &mut Report,
) {
    let truth = Truth::new(centres, args);
    let all = seen.moving.len() + seen.stopped.len() + seen.steps.len() + 1;
    eprintln!(
        "{all} references of {} texels with {} paths each",
        truth.centres.len(),
        args.samples
    );
    let mut noise = Vec::new();
    let mut converged = |scene: &Scene| {
        let converged = converge(scene, &truth.centres, &truth.settings);
        noise.extend(compared(&converged.texels).into_iter().map(|i| converged.relative_se[i]));
        converged.texels
    };
    let mut errors = |moments: &[Moment]| {
        let errors: Vec<_> = moments
            .iter()
            .map(|m| relative_errors(&truth.pick(&m.texels), &converged(&m.scene)))
            .collect();
        ErrorSummary::of(&errors)
    };
    report.error_moving = errors(&seen.moving);
    report.error_after_stop = errors(&seen.stopped);
    report.error_picture = errors(std::slice::from_ref(shown));

    let mut at_rest = Vec::new();
    let mut times = Vec::new();
    for step in &seen.steps {
        let before = converged(&step.before.scene);
        let shown = truth.pick(&step.before.texels);
        at_rest.push(relative_errors(&shown, &before));
        let after = match brighter(&step.before.scene, &step.after) {
            Some(factor) => before.iter().map(|texel| *texel * factor).collect(),
            None => converged(&step.after),
        };
        times.push(step_times(&before, &after, &shown, &truth.writes(step)));
    }
    eprintln!();
    report.error_before_step = ErrorSummary::of(&at_rest);
    report.reference_noise = quantile(&noise, 0.5).unwrap_or(f32::NAN);
    let spread = |of: fn(&StepTimes) -> Option<f32>| {
        Spread::of(&times.iter().filter_map(of).collect::<Vec<_>>())
    };
    report.steps = times.len();
    report.steps_not_arrived = times.iter().filter(|t| t.median_receiver_90_ms.is_none()).count();
    report.step_receivers = spread(|t| Some(t.receivers as f32));
    report.step_first_texel_ms = spread(|t| t.first_texel_ms);
    report.step_90_ms = spread(|t| t.median_receiver_90_ms);
    report.step_90_of_receivers_ms = spread(|t| t.receivers_90_ms);
    report.step_90_of_sum_ms = spread(|t| t.sum_90_ms);
    report.step_runs = times;
    report.updates = seen.updates;
    report.updates_per_s = seen.updates as f32 / seen.moving_time.as_secs_f32().max(f32::EPSILON);
}

/// Converged values at some texels.
struct Truth {
    centres: Vec<TexelCentre>,
    /// Places of the texels in all pages, one after the other.
    indices: Vec<usize>,
    settings: GatherSettings,
}

impl Truth {
    fn new(all: &[TexelCentre], args: &Args) -> Self {
        let count = all.len().min(ERROR_TEXELS);
        let centres: Vec<_> = (0..count).map(|i| all[i * all.len() / count]).collect();
        let edge = args.lightmap as usize;
        let indices = centres
            .iter()
            .map(|c| {
                let [page, x, y] = c.texel.map(|v| v as usize);
                (page * edge + y) * edge + x
            })
            .collect();
        Self { centres, indices, settings: GatherSettings { paths: args.samples, seed: args.seed } }
    }

    fn pick(&self, texels: &[Vec3]) -> Vec<Vec3> {
        self.indices.iter().map(|&i| texels.get(i).copied().unwrap_or_default()).collect()
    }

    fn writes(&self, step: &Step) -> Vec<Written> {
        let ms = |at: Instant| at.saturating_duration_since(step.at).as_secs_f32() * 1e3;
        step.writes
            .iter()
            .map(|write| Written {
                first_ms: ms(write.first),
                at_ms: ms(write.all),
                knows: write.snapshot >= step.snapshot,
                texels: self.pick(&write.texels),
            })
            .collect()
    }
}

/// The factor by which all light of `after` exceeds that of `before`, if that is all that differs:
/// light is linear, so the converged texels differ by it too.
fn brighter(before: &Scene, after: &Scene) -> Option<f32> {
    let dark = |scene: &Scene| {
        scene.sky.is_black() && scene.materials.values().all(|m| m.emissive == Vec3::ZERO)
    };
    if !dark(before) || !dark(after) || before.lights.len() != after.lights.len() {
        return None;
    }
    let pairs = || before.lights.values().zip(after.lights.values());
    let (b, a) = pairs().next()?;
    let factor = a.intensity.element_sum() / b.intensity.element_sum();
    let scaled = pairs().all(|(b, a)| Light { intensity: b.intensity * factor, ..*b } == *a);
    (scaled && factor.is_finite()).then_some(factor)
}
