//! Rays against a world with cut-out materials, and robust ray origins.

use glam::Vec3;

use crate::{
    Hit, Ray, World,
    scene::{Light, LightKind},
};

/// Ends shadow rays just before a light, so that a light placed on a surface is not hidden by it.
const SHADOW_END: f32 = 1.0 - 1e-5;

/// Smallest distance in metres by which ray origins are moved off their surface.
const MIN_OFFSET: f32 = 1e-5;

/// A surface point moved to the side of its normal, so that a ray from it does not meet the surface
/// it starts on.
///
/// The distance grows with the coordinates, as their rounding errors do: 2⁻¹⁷ of the largest (about
/// 64 units in the last place, where interpolated positions are wrong by a few), at least 10 µm.
#[must_use]
pub fn offset_origin(position: Vec3, normal: Vec3) -> Vec3 {
    const RELATIVE: f32 = 1.0 / 131_072.0;
    position + normal * (position.abs().max_element() * RELATIVE).max(MIN_OFFSET)
}

/// The ray whose free passage means that `origin` sees `light`.
#[must_use]
pub fn shadow_ray(origin: Vec3, light: &Light) -> Ray {
    match light.kind {
        LightKind::Directional => Ray::new(origin, -light.direction),
        LightKind::Point | LightKind::Spot { .. } => {
            Ray { t_max: SHADOW_END, ..Ray::new(origin, light.position - origin) }
        }
    }
}

impl World {
    /// The closest hit that is there: transparent texels of cut-out materials let the ray through.
    #[must_use]
    pub fn closest(&self, ray: &Ray) -> Hit {
        let mut hit = self.tracer.closest(ray);
        if self.has_masks() {
            let mut rest = *ray;
            while hit.is_hit() && self.is_cut_out(&hit) {
                // Two units in the last place further: always forward, whatever the tracer rounds.
                let passed = hit.t.max(rest.t_min);
                rest.t_min = (passed * (1.0 + f32::EPSILON)).next_up();
                hit = self.tracer.closest(&rest);
            }
        }
        hit
    }

    /// Whether anything that is there lies on the ray's segment.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        if self.has_masks() { self.closest(ray).is_hit() } else { self.tracer.occluded(ray) }
    }

    /// Whether the open segment from a point to a light (for a directional light: the ray against
    /// its direction) meets nothing. The point is taken as it is; cone and range of the light do
    /// not count.
    #[must_use]
    pub fn sees_light(&self, point: Vec3, light: &Light) -> bool {
        !self.occluded(&shadow_ray(point, light))
    }
}
