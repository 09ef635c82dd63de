//! Rays that are traced while light is still, and not kept.
//!
//! They go on with the sequence of the kept ones and look closer: direct light, reflectance and
//! emission are those of the very point that a ray meets, not of its patch; only what comes from
//! further bounces is the patch's. So they take out, ray by ray, both the noise of the kept rays and
//! the error that patches of finite size make. Both kinds have about the same variance, hence the
//! best blend weighs each ray the same, and nothing jumps when the closer look takes over.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

use super::{Lighting, luminance, median};
use crate::{
    Ray, World,
    lightmap::{
        patches::Patches,
        transport::{Origin, family_ray, family_seed},
    },
    path::{SAMPLE_ALL_LIGHTS, direct_irradiance},
    scene::{DirectSky, Sky},
    visibility::offset_origin,
};

/// Rays that one slice traces.
const SLICE: usize = 1 << 15;

/// Median of the square of a normally distributed number.
const MEDIAN_SQUARE: f32 = 0.455;

/// Sums of radiance.
#[derive(Default)]
pub(super) struct Refined {
    /// Rays a texel in `sums`.
    pub rays: u32,
    sums: Vec<Vec3>,
    /// The pass that is worked on: as many rays as there are already.
    pass: Vec<Vec3>,
    /// Square of the relative error that patches make, as far as the two kinds of rays disagree beyond
    /// their noise; it is kept when light changes.
    pub model_error: f32,
}

impl Refined {
    /// Forgets the sums, after light changed.
    pub(super) fn clear(&mut self) {
        self.rays = 0;
        self.sums.clear();
        self.pass.clear();
    }
}

impl Lighting {
    /// Traces one slice of rays that are not kept, up to `most` rays a texel of both kinds. `None` if
    /// there is nothing left to trace, else whether what is shown became better.
    pub(crate) fn refine(&mut self, most: u32) -> Option<bool> {
        let fronts = self.patches.fronts;
        let done = self.rays();
        if fronts == 0 || done == 0 || done.saturating_mul(2) > most.max(1) {
            return None;
        }
        let start = self.refined.pass.len();
        let end = fronts.min(start + (SLICE / done as usize).max(1));
        let seed = self.limits.seed;
        let (world, patches) = (&self.world, &self.patches);
        let known = Known {
            arriving: &self.arriving,
            sky: &self.sky,
            bounced: &self.bounced,
            straight: (self.direct_sky == DirectSky::Included).then_some(&self.soft_sky),
        };
        let new: Vec<Vec3> = (start..end)
            .into_par_iter()
            .map(|i| {
                let origin = Origin::Surface(patches.position[i], patches.normal[i]);
                let seed = family_seed(seed, i);
                (done..done * 2)
                    .map(|ray| {
                        let ray = family_ray(&origin, ray, seed);
                        look(world, patches, &known, &ray)
                    })
                    .sum()
            })
            .collect();
        self.refined.pass.extend(new);
        if end < fronts {
            return Some(false);
        }
        self.end_pass(done);
        self.finish();
        Some(true)
    }

    fn end_pass(&mut self, done: u32) {
        let kept = self.kept_rays();
        let pass = std::mem::take(&mut self.refined.pass);
        self.refined.sums.resize(pass.len(), Vec3::ZERO);
        let brightest = self.gathered.iter().map(|e| luminance(*e)).fold(0.0, f32::max);
        let (mut seen, mut expected) = (Vec::new(), Vec::new());
        for (i, new) in pass.iter().enumerate() {
            let old = self.blend(i, kept);
            let difference = luminance(old - *new * (PI / done as f32));
            // The first pass compares the two kinds, as many rays each; their noise is the spread.
            if self.refined.rays == 0 && luminance(old) > brightest * 0.01 && self.valid[i] {
                seen.push((difference / luminance(old)).powi(2));
                expected.push(2.0 * (self.spread[i] / luminance(old)).powi(2));
            }
            self.spread[i] = difference.abs() * 0.5;
        }
        if let (Some(seen), Some(expected)) = (median(&mut seen), median(&mut expected)) {
            self.refined.model_error = (seen - expected).max(0.0) / MEDIAN_SQUARE;
        }
        for (sum, new) in self.refined.sums.iter_mut().zip(pass) {
            *sum += new;
        }
        self.refined.rays += done;
    }

    /// Irradiance at a texel from both kinds of rays.
    pub(super) fn blend(&self, texel: usize, kept: u32) -> Vec3 {
        let refined = self.refined.rays as f32;
        let Some(sum) = self.refined.sums.get(texel) else { return self.gathered[texel] };
        (self.gathered[texel] * kept as f32 + *sum * PI) / (kept as f32 + refined)
    }
}

/// What the last solution knows about patches: irradiance.
struct Known<'a> {
    /// From lights and sky.
    arriving: &'a [Vec3],
    /// From the sky.
    sky: &'a [Vec3],
    /// From other patches.
    bounced: &'a [Vec3],
    /// What a texel's rays see that meet nothing.
    straight: Option<&'a Sky>,
}

/// Radiance along a ray.
fn look(world: &World, patches: &Patches, known: &Known<'_>, ray: &Ray) -> Vec3 {
    let hit = world.closest(ray);
    if !hit.is_hit() {
        return known.straight.map_or(Vec3::ZERO, |sky| sky.radiance(ray.direction));
    }
    let surface = world.surface(&hit, ray.direction);
    let patch = patches.find(patches.meet(world, &hit, ray.direction));
    let at =
        |values: &[Vec3]| patch.and_then(|p| values.get(p as usize)).copied().unwrap_or(Vec3::ZERO);
    let straight = if world.lights.len() <= SAMPLE_ALL_LIGHTS {
        let origin = offset_origin(surface.position, surface.normal);
        direct_irradiance(world, surface.position, surface.normal, origin) + at(known.sky)
    } else {
        at(known.arriving)
    };
    surface.emission + surface.albedo / PI * (straight + at(known.bounced))
}
