//! The light that surfaces show to rays: exact where it matters, remembered where it doesn't.
//!
//! A gather ray that meets the front of a texel takes what is known about that texel: its albedo and its
//! irradiance straight from punctual lights (the mean over its area), and the irradiance from
//! everything else of its cell ([`Links`](super::links)). Where it meets something too near for that to
//! be exact, or something without texels (backs, surfaces without a second UV set), it goes on as a
//! path, with all the techniques of the [path tracer](crate::path), until it meets such a texel.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec3, Vec4, Vec4Swizzles};

use super::{
    Layout,
    cells::Cells,
    lobe::{Cosine, Lobe},
    map::{Met, TexelMap},
    sources::Sources,
};
use crate::{
    Hit, Ray, World,
    lightmap::NONE,
    path::{EMITTER_END, PathTracer, Toward, balance},
    sampling::PathSampler,
    visibility::offset_origin,
};

/// What a ray meets nearer than this many edges of its cell is followed further. With coarse texels,
/// where it matters most, the sum of light differs from the path tracer's by -0.17 +- 0.03 % (TwoRooms,
/// 3.3 texels a metre) and +0.02 +- 0.03 % (CornellBox, 2.5): `examples/bake_error.rs`.
const NEAR: f32 = 1.0;
/// What a ray meets nearer than this many texels gets its own shadow rays.
const NEAREST: f32 = 3.0;

/// What is known about light.
pub(super) struct Field<'a> {
    pub(super) tracer: PathTracer<'a>,
    pub(super) layout: &'a Layout,
    pub(super) map: TexelMap,
    pub(super) cells: Cells,
    /// Most reflections.
    pub(super) bounces: u32,
    /// For each texel: irradiance straight from punctual lights.
    pub(super) direct: Vec<Vec3>,
    /// For each texel: whether what arrives straight from lights varies much within it.
    pub(super) uneven: Vec<bool>,
    /// For each cell: irradiance from all else, reflected at most so many times as the index says; a
    /// single entry where there is no limit.
    pub(super) levels: Vec<Vec<Vec3>>,
    /// For each texel: radiance that leaves it, with as many reflections as there may be for a texel
    /// that it lights; and the probability with which it is drawn as a source.
    pub(super) leaving: Vec<Vec4>,
    pub(super) sources: Sources,
}

impl<'a> Field<'a> {
    pub(super) fn world(&self) -> &'a World {
        self.tracer.world()
    }

    /// Radiance that leaves a texel for a place that light has left with `before` reflections to go.
    fn leaving(&self, texel: u32, before: u32) -> Vec3 {
        let t = texel as usize;
        if before == 0 || self.bounces == u32::MAX {
            return self.leaving[t].xyz();
        }
        // This reflection is one of those that are left.
        match self.bounces.checked_sub(before + 1).and_then(|level| self.levels.get(level as usize))
        {
            Some(level) => {
                self.layout.patches.albedo[t]
                    * FRAC_1_PI
                    * (self.direct[t] + level[self.cells.of[t] as usize])
            }
            None => Vec3::ZERO,
        }
    }

    /// [`leaving`](Self::leaving) at a point of a texel, seen from `origin`.
    fn leaving_at(&self, met: &Met, origin: Vec3, before: u32, sampler: &mut PathSampler) -> Vec3 {
        let leaving = self.leaving(met.texel, before);
        if leaving == Vec3::ZERO {
            return leaving;
        }
        leaving + self.unevenness(met, origin, sampler).unwrap_or_default()
    }

    /// By how much what leaves a point differs from what leaves its texel in the mean, for uneven texels.
    pub(super) fn unevenness(
        &self,
        met: &Met,
        origin: Vec3,
        sampler: &mut PathSampler,
    ) -> Option<Vec3> {
        let t = met.texel as usize;
        if !self.uneven[t] {
            return None;
        }
        let (position, normal) = (origin + met.way, self.world().normal(met.triangle));
        let next = offset_origin(position, normal);
        let exact = self.tracer.punctual(position, normal, next, sampler);
        Some(self.layout.patches.albedo[t] * FRAC_1_PI * (exact - self.direct[t]))
    }

    /// Whether a texel is far enough for what is known about it.
    fn knows(&self, met: &Met) -> bool {
        let near = NEAR * self.cells.edge as f32;
        self.cells.of[met.texel as usize] != NONE
            && met.distance * met.distance * met.density >= near * near
    }

    /// One sample of the light at a point: hands directions and radiance divided by the density of all
    /// techniques to `add`. `sky`: whether what comes straight from the sky counts.
    pub(super) fn sample(
        &self,
        origin: Vec3,
        lobe: &impl Lobe,
        sky: bool,
        sampler: &mut PathSampler,
        mut add: impl FnMut(Vec3, Vec3),
    ) {
        let (direction, pdf) = lobe.draw(sampler.next_2d());
        for toward in self.toward(origin, lobe, sky, 0, sampler).into_iter().flatten() {
            add(toward.direction, toward.weighted);
        }
        if pdf > 0.0 {
            let radiance = self.follow(Ray::new(origin, direction), pdf, sky, sampler);
            add(direction, radiance / pdf);
        }
    }

    /// Light from emitters, the sky, and bright texels, one sample each.
    fn toward(
        &self,
        origin: Vec3,
        lobe: &impl Lobe,
        sky: bool,
        before: u32,
        sampler: &mut PathSampler,
    ) -> [Option<Toward>; 3] {
        let pdf = |d: Vec3| lobe.pdf(d);
        [
            self.tracer.toward_emitter(origin, sampler, pdf),
            if sky { self.tracer.toward_sky(origin, sampler, pdf) } else { None },
            self.toward_source(origin, lobe, before, true, sampler),
        ]
    }

    /// Light from a bright texel; `far`: only where gather rays take what is known about it.
    pub(super) fn toward_source(
        &self,
        origin: Vec3,
        lobe: &impl Lobe,
        before: u32,
        far: bool,
        sampler: &mut PathSampler,
    ) -> Option<Toward> {
        if self.sources.is_empty() {
            return None;
        }
        let (texel, place) = self.sources.draw(sampler);
        let met = self.map.point(self.world(), self.layout, texel, place, origin)?;
        let direction = met.way / met.distance;
        let other = lobe.pdf(direction);
        if other <= 0.0 || (far && !self.knows(&met)) {
            return None;
        }
        let ray = Ray { t_max: EMITTER_END, ..Ray::new(origin, met.way) };
        if self.world().occluded(&ray) {
            return None;
        }
        let pdf = self.leaving[texel as usize].w * met.solid_angle_pdf();
        let leaving = self.leaving_at(&met, origin, before, sampler);
        Some(Toward { direction, weighted: leaving / (pdf + other) })
    }

    /// Radiance that arrives along a ray that was drawn with density `pdf`.
    fn follow(&self, ray: Ray, pdf: f32, sky: bool, sampler: &mut PathSampler) -> Vec3 {
        let mut look = Look { field: self, sum: Vec3::ZERO };
        self.walk(ray, pdf, sky, sampler, &mut look);
        look.sum
    }

    /// Follows a path until `walker` ends it.
    pub(super) fn walk(
        &self,
        mut ray: Ray,
        mut pdf: f32,
        sky: bool,
        sampler: &mut PathSampler,
        walker: &mut impl Walker,
    ) {
        let world = self.world();
        let (mut throughput, mut before) = (Vec3::ONE, 0);
        loop {
            let hit = world.closest(&ray);
            if !hit.is_hit() {
                if before > 0 || sky {
                    let radiance = self.tracer.sky_met(ray.direction, Some(pdf));
                    walker.light(throughput * radiance, before);
                }
                return;
            }
            walker.light(throughput * self.emitted(&ray, &hit, pdf), before);
            if before >= self.bounces {
                return;
            }
            let met = self.map.meet(world, self.layout, &ray, &hit);
            if let Some(met) = met
                && self.cells.of[met.texel as usize] != NONE
                && walker.ends(&End { met, origin: ray.origin, pdf, throughput, before }, sampler)
            {
                return;
            }
            let surface = world.surface(&hit, ray.direction);
            throughput *= surface.albedo;
            if throughput == Vec3::ZERO {
                return;
            }
            before += 1;
            let next = offset_origin(surface.position, surface.normal);
            let lit = self.punctual(&surface, met, next, sampler);
            walker.light(throughput * FRAC_1_PI * lit, before);
            let lobe = Cosine::new(surface.normal);
            for toward in self.toward(next, &lobe, true, before, sampler).into_iter().flatten() {
                // The reflectance times the cosine is the albedo times the density of the gather ray.
                let light = toward.weighted * lobe.pdf(toward.direction);
                walker.light(throughput * light, before);
            }
            if !self.tracer.goes_on(&mut throughput, before, sampler) {
                return;
            }
            let (direction, drawn) = lobe.draw(sampler.next_2d());
            if drawn <= 0.0 {
                return;
            }
            (ray, pdf) = (Ray::new(next, direction), drawn);
        }
    }

    /// Irradiance straight from punctual lights at a hit: that of its texel, or exact where it is so near
    /// that the texel is seen.
    fn punctual(
        &self,
        surface: &crate::world::Surface,
        met: Option<Met>,
        next: Vec3,
        sampler: &mut PathSampler,
    ) -> Vec3 {
        if let Some(met) = met
            && self.cells.of[met.texel as usize] != NONE
            && met.distance * met.distance * met.density >= NEAREST * NEAREST
        {
            return self.direct[met.texel as usize];
        }
        self.tracer.punctual(surface.position, surface.normal, next, sampler)
    }

    fn emitted(&self, ray: &Ray, hit: &Hit, pdf: f32) -> Vec3 {
        let world = self.world();
        let instance = &world.instances()[world.instance_of(hit.triangle) as usize];
        if instance.material.emissive == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let surface = world.surface(hit, ray.direction);
        self.tracer.emission_met(&surface, ray, hit, Some(pdf))
    }
}

/// What follows a path.
pub(super) trait Walker {
    /// Light that arrives at the path's first point, reflected `before` times.
    fn light(&mut self, radiance: Vec3, before: u32);
    /// Whether the path ends at a texel that has a cell.
    fn ends(&mut self, end: &End, sampler: &mut PathSampler) -> bool;
}

/// Sums the light of a path that ends where the field knows what leaves a texel.
struct Look<'a> {
    field: &'a Field<'a>,
    sum: Vec3,
}

impl Walker for Look<'_> {
    fn light(&mut self, radiance: Vec3, _: u32) {
        self.sum += radiance;
    }

    fn ends(&mut self, end: &End, sampler: &mut PathSampler) -> bool {
        let (field, met) = (self.field, &end.met);
        if !field.knows(met) {
            return false;
        }
        let source = field.leaving[met.texel as usize].w;
        let weight = if source > 0.0 && met.exact {
            balance(Some(end.pdf), source * met.solid_angle_pdf())
        } else {
            1.0
        };
        let leaving = field.leaving_at(met, end.origin, end.before, sampler);
        self.sum += end.throughput * leaving * weight;
        true
    }
}

/// Where a path may end.
pub(super) struct End {
    pub(super) met: Met,
    /// Where the ray that met it began.
    pub(super) origin: Vec3,
    /// Density of the ray that met it.
    pub(super) pdf: f32,
    /// What of the radiance that leaves it arrives at the path's first point.
    pub(super) throughput: Vec3,
    /// Reflections between.
    pub(super) before: u32,
}
