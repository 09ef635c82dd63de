//! How a yarn's surface reflects: a diffuse part, and facets that follow the fibres.
//!
//! Fibres are thin cylinders: their normals spread widely across them and little along them, which
//! draws highlights out across the yarn. Anisotropic GGX with Smith's height-correlated masking
//! (Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2)):
//! reciprocal, and never more light than came.

use glam::Vec3;

use crate::weave::Surface;

/// Roughness along the fibres and across them.
const ROUGHNESS: [f32; 2] = [0.24, 0.62];
/// Reflectance straight on, of cellulose.
const STRAIGHT: f32 = 0.05;
/// Of the light that comes in, what the facets leave to the diffuse part.
pub(crate) const DIFFUSE: f32 = 0.94;

/// A surface and a view, ready for many lights.
pub(crate) struct Shading {
    view: Vec3,
    axes: [Vec3; 3],
    masked_view: f32,
}

impl Shading {
    pub(crate) fn new(surface: &Surface, view: Vec3) -> Self {
        let axes = [surface.fibre, surface.normal.cross(surface.fibre), surface.normal];
        let view_local = axes.map(|axis| axis.dot(view));
        Self { view, axes, masked_view: stretched(view_local) }
    }

    /// pi times the facets' BRDF, for a light with `cos_light` > 0.
    pub(crate) fn facets(&self, light: Vec3, cos_light: f32) -> f32 {
        let half = (self.view + light).normalize();
        let [x, y, z] = self.axes.map(|axis| axis.dot(half));
        let [rough_x, rough_y] = ROUGHNESS;
        let spread = (x / rough_x).powi(2) + (y / rough_y).powi(2) + z * z;
        let density = 1.0 / (rough_x * rough_y * spread * spread);
        let cos_view = self.axes[2].dot(self.view).max(1e-3);
        let light_local = self.axes.map(|axis| axis.dot(light));
        let visibility =
            0.5 / (cos_light * self.masked_view + cos_view * stretched(light_local)).max(1e-4);
        let grazing = (1.0 - half.dot(light).max(0.0)).powi(5);
        density * visibility * (STRAIGHT + (1.0 - STRAIGHT) * grazing)
    }
}

fn stretched([x, y, z]: [f32; 3]) -> f32 {
    Vec3::new(ROUGHNESS[0] * x, ROUGHNESS[1] * y, z).length()
}
