//! Irradiance at arbitrary points.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;
use rayon::prelude::*;

use crate::{
    World,
    estimate::{Estimate, GatherSettings, Progress, estimate},
    path::{PathTracer, direct_irradiance},
    sampling::{Frame, PathSampler, cosine_hemisphere},
};

/// Distance in metres by which rays start off a receiver.
const OFFSET: f32 = 1e-4;

/// A point on a surface, and the side from which it is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// World position in metres.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
}

/// Irradiance at a receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReceiverLight {
    /// Straight from punctual lights (exact) and from the sky (estimated).
    pub direct: Estimate,
    /// Everything else: emitted by surfaces, or reflected any number of times.
    pub indirect: Estimate,
    /// The part of `indirect` that was reflected once at most.
    pub one_bounce: Estimate,
}

/// A sample of the irradiance at a receiver; its mean over many is the irradiance.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SampledLight {
    /// Straight from the sky.
    pub(crate) sky: Vec3,
    /// Emitted by surfaces, or reflected any number of times.
    pub(crate) indirect: Vec3,
    /// The part of `indirect` that was reflected once at most.
    pub(crate) one_bounce: Vec3,
}

impl Receiver {
    /// Where its rays start: 0.1 mm off the surface, more where coordinates are so large that this
    /// would drown in rounding.
    #[must_use]
    pub fn origin(&self) -> Vec3 {
        let rounding = self.position.abs().max_element() * (1.0 / 131_072.0);
        self.position + self.normal * OFFSET.max(rounding)
    }

    /// Irradiance straight from the punctual lights, exact.
    #[must_use]
    pub fn direct(&self, world: &World) -> Vec3 {
        direct_irradiance(world, self.position, self.normal, self.origin())
    }

    /// All parts of the irradiance. `stream` names the receiver's random numbers: equal streams
    /// and seeds give equal results. `None` if `progress` stopped the work.
    #[must_use]
    pub fn gather(
        &self,
        tracer: &PathTracer<'_>,
        settings: &GatherSettings,
        stream: u64,
        progress: Progress<'_>,
    ) -> Option<ReceiverLight> {
        let [mut direct, indirect, one_bounce] =
            estimate(settings, stream, progress, |sampler, sums| {
                let light = self.sample(tracer, sampler);
                sums[0] += light.sky.as_dvec3();
                sums[1] += light.indirect.as_dvec3();
                sums[2] += light.one_bounce.as_dvec3();
            })?;
        direct.mean += self.direct(tracer.world());
        Some(ReceiverLight { direct, indirect, one_bounce })
    }

    /// One sample of the irradiance, without what arrives straight from punctual lights.
    pub(crate) fn sample(
        &self,
        tracer: &PathTracer<'_>,
        sampler: &mut PathSampler,
    ) -> SampledLight {
        let (origin, frame) = (self.origin(), Frame::new(self.normal));
        let cosine_pdf = |d: Vec3| self.normal.dot(d).max(0.0) * FRAC_1_PI;
        let local = cosine_hemisphere(sampler.next_2d());
        let (mut sky, mut emitted) = (Vec3::ZERO, Vec3::ZERO);
        if let Some(toward) = tracer.toward_emitter(origin, sampler, cosine_pdf) {
            emitted = toward.weighted * self.normal.dot(toward.direction);
        }
        if let Some(toward) = tracer.toward_sky(origin, sampler, cosine_pdf) {
            sky = toward.weighted * self.normal.dot(toward.direction);
        }
        let pdf = Some(local.z * FRAC_1_PI);
        let arriving = tracer.trace_weighed(origin, frame.to_world(local), pdf, sampler);
        // Directions have density cos θ / π, so E = π times the mean radiance.
        SampledLight {
            sky: sky + arriving.sky * PI,
            indirect: arriving.indirect * PI + emitted,
            one_bounce: arriving.one_bounce * PI + emitted,
        }
    }
}

/// Irradiance at many receivers, on all threads of the current rayon pool. The result depends on
/// the seed and on each receiver's place in the list, not on the number of threads. `None` if
/// `progress` stopped the work.
#[must_use]
pub fn gather_receivers(
    world: &World,
    receivers: &[Receiver],
    settings: &GatherSettings,
    progress: Progress<'_>,
) -> Option<Vec<ReceiverLight>> {
    let tracer = PathTracer::new(world);
    receivers
        .par_iter()
        .enumerate()
        .map(|(i, receiver)| receiver.gather(&tracer, settings, i as u64, progress))
        .collect()
}
