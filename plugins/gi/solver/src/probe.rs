//! Radiance at points in the air, in spherical harmonics.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::{
    World,
    estimate::{Estimate, GatherSettings, Progress, estimate},
    path::PathTracer,
    sampling::uniform_sphere,
    sh::{ShRgb, sh_basis},
};

/// Keeps the random numbers of probes apart from those of receivers.
const STREAM: u64 = 1 << 63;

/// Density per solid angle of its directions.
const PDF: f32 = 1.0 / (4.0 * PI);

/// Incident radiance at a probe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProbeLight {
    /// From surfaces: emitted, or reflected any number of times.
    pub indirect: ShRgb,
    /// Standard error of each coefficient of `indirect`.
    pub indirect_se: ShRgb,
    /// Straight from the sky.
    pub sky: ShRgb,
    /// Standard error of each coefficient of `sky`.
    pub sky_se: ShRgb,
}

/// Gathers one probe from uniformly distributed directions. `stream` names its random numbers:
/// equal streams and seeds give equal results. `None` if `progress` stopped the work.
#[must_use]
pub fn gather_probe(
    tracer: &PathTracer<'_>,
    position: Vec3,
    settings: &GatherSettings,
    stream: u64,
    progress: Progress<'_>,
) -> Option<ProbeLight> {
    let estimates: [Estimate; 18] =
        estimate(settings, STREAM | stream, progress, |sampler, sums: &mut [DVec3; 18]| {
            let direction = uniform_sphere(sampler.next_2d());
            if let Some(toward) = tracer.toward_emitter(position, sampler, |_| PDF) {
                add(sums, toward.direction, toward.weighted, Vec3::ZERO);
            }
            if let Some(toward) = tracer.toward_sky(position, sampler, |_| PDF) {
                add(sums, toward.direction, Vec3::ZERO, toward.weighted);
            }
            let arriving = tracer.trace_weighed(position, direction, Some(PDF), sampler);
            add(sums, direction, arriving.indirect / PDF, arriving.sky / PDF);
        })?;
    let part = |first: usize, f: fn(&Estimate) -> Vec3| {
        ShRgb(std::array::from_fn(|i| f(&estimates[first + i])))
    };
    Some(ProbeLight {
        indirect: part(0, |e| e.mean),
        indirect_se: part(0, |e| e.se),
        sky: part(9, |e| e.mean),
        sky_se: part(9, |e| e.se),
    })
}

/// Adds light from one direction, already divided by its density, to the coefficients of indirect
/// light and of the sky.
fn add(sums: &mut [DVec3; 18], direction: Vec3, indirect: Vec3, sky: Vec3) {
    for (i, y) in sh_basis(direction).into_iter().enumerate() {
        sums[i] += (indirect * y).as_dvec3();
        sums[9 + i] += (sky * y).as_dvec3();
    }
}

/// Gathers many probes, on all threads of the current rayon pool. The result depends on the seed
/// and on each probe's place in the list, not on the number of threads. `None` if `progress`
/// stopped the work.
#[must_use]
pub fn gather_probes(
    world: &World,
    positions: &[Vec3],
    settings: &GatherSettings,
    progress: Progress<'_>,
) -> Option<Vec<ProbeLight>> {
    let tracer = PathTracer::new(world);
    positions
        .par_iter()
        .enumerate()
        .map(|(i, position)| gather_probe(&tracer, *position, settings, i as u64, progress))
        .collect()
}
