//! Punctual lights.

use glam::Vec3;

/// The shapes of `KHR_lights_punctual` and of Bevy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Shines equally in all directions.
    Point,
    /// Shines in a cone around the light's direction; half angles in radians, inner < outer.
    Spot {
        /// Full intensity inside.
        inner_angle: f32,
        /// Nothing outside.
        outer_angle: f32,
    },
    /// Parallel light from infinitely far away.
    Directional,
}

/// A punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Its shape.
    pub kind: LightKind,
    /// World position (not used by directional lights).
    pub position: Vec3,
    /// Unit direction in which the light travels (not used by point lights).
    pub direction: Vec3,
    /// Point and spot: radiant or luminous intensity (W/sr, cd). Directional: irradiance on a plane
    /// that faces the light (W/m², lx). Linear RGB.
    pub intensity: Vec3,
    /// Distance in metres at which Bevy's range window reaches 0; infinity for pure 1/r².
    pub range: f32,
}

/// What a light sends to a point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit vector from the point towards the light.
    pub to_light: Vec3,
    /// Distance to the light, infinite for directional ones.
    pub distance: f32,
    /// Irradiance on a plane at the point that faces the light, without visibility.
    pub irradiance: Vec3,
}

impl Light {
    /// The unshadowed light that arrives at `point`; `None` where there is none.
    ///
    /// The range window is the one of Karis 2013 ("Real Shading in Unreal Engine 4") that Bevy uses:
    /// `saturate(1 - (d/range)^4)² / d²`; the cone is the recommendation of `KHR_lights_punctual`.
    #[must_use]
    pub fn sample(&self, point: Vec3) -> Option<LightSample> {
        if self.kind == LightKind::Directional {
            return Some(LightSample {
                to_light: -self.direction,
                distance: f32::INFINITY,
                irradiance: self.intensity,
            });
        }
        let offset = self.position - point;
        let distance_squared = offset.length_squared();
        if !(distance_squared > 1e-12 && distance_squared.is_finite()) {
            return None;
        }
        let distance = distance_squared.sqrt();
        let to_light = offset / distance;
        let window = if self.range.is_finite() {
            let ratio = distance_squared / (self.range * self.range);
            (1.0 - ratio * ratio).clamp(0.0, 1.0).powi(2)
        } else {
            1.0
        };
        let cone = match self.kind {
            LightKind::Spot { inner_angle, outer_angle } => {
                let cos_outer = outer_angle.cos();
                let scale = 1.0 / (inner_angle.cos() - cos_outer).max(1e-4);
                let cos = (-to_light).dot(self.direction);
                ((cos - cos_outer) * scale).clamp(0.0, 1.0).powi(2)
            }
            _ => 1.0,
        };
        let factor = window * cone / distance_squared;
        (factor > 0.0).then(|| LightSample {
            to_light,
            distance,
            irradiance: self.intensity * factor,
        })
    }
}
