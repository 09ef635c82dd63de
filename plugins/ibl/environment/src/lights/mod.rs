//! A map as a sum of directional lights.

mod density;
mod independent;
mod method;

use glam::Vec3;

use crate::Environment;
use density::Density;
pub use method::{Method, UnknownName};

/// Most lights of a request.
const MOST: u32 = 4096;

/// Which lights are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightRequest {
    /// How many, 1 to 4096; other numbers are taken as the nearest of these.
    pub count: u32,
    /// How they are found.
    pub method: Method,
    /// Other seeds give other lights, which are as good.
    pub seed: u64,
}

impl Default for LightRequest {
    /// 200 lights by the best method.
    fn default() -> Self {
        Self { count: 200, method: Method::default(), seed: 0 }
    }
}

/// Light that comes from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentLight {
    /// Unit vector towards the light, in the map's frame.
    pub direction: Vec3,
    /// Linear Rec. 709 irradiance of a plane that faces the light, in the map's unit of radiance
    /// times steradian.
    pub irradiance: Vec3,
}

impl Environment {
    /// Lights whose sum replaces the map; always as many as were asked for.
    ///
    /// Any first n of the N lights, their irradiance times N / n, are an estimate of all that is
    /// right on average over seeds. A black map gives lights of no irradiance, in directions all round.
    #[must_use]
    pub fn lights(&self, request: &LightRequest) -> Vec<EnvironmentLight> {
        let count = request.count.clamp(1, MOST) as usize;
        let density = Density::new(self);
        independent::lights(&density, count, request.seed)
    }
}
