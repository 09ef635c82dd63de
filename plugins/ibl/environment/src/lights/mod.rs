//! A map as a sum of directional lights.

mod density;
mod independent;
mod method;
mod order;
mod regions;
mod stratified;
mod sums;
mod worth;

use glam::Vec3;

use crate::{Environment, random::Random};
use density::Density;
pub use method::{Method, UnknownName};
use sums::Sums;
use worth::Worth;

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
    /// Any n consecutive ones of the N lights, their irradiance times N / n, are an estimate of all
    /// that is right on average over seeds. A black map gives lights of no irradiance, in directions
    /// all round.
    #[must_use]
    pub fn lights(&self, request: &LightRequest) -> Vec<EnvironmentLight> {
        LightExtractor::new(self, request.method).lights(request.count, request.seed)
    }
}

/// Tables of a map for a method, from which lights come quickly, for several counts or seeds.
pub struct LightExtractor<'a> {
    method: Method,
    tables: Tables<'a>,
}

enum Tables<'a> {
    Density(Density<'a>),
    Sums(Sums<'a>),
}

impl<'a> LightExtractor<'a> {
    /// Makes the tables: up to 70 MiB for the largest maps.
    #[must_use]
    pub fn new(environment: &'a Environment, method: Method) -> Self {
        let tables = match method {
            Method::Independent | Method::Stratified => Tables::Density(Density::new(environment)),
            Method::Regions => Tables::Sums(Sums::new(environment, &Worth::even())),
            Method::Centroids => Tables::Sums(Sums::new(environment, &Worth::new(environment))),
        };
        Self { method, tables }
    }

    /// The lights of a [`LightRequest`] of these numbers; see [`Environment::lights`].
    #[must_use]
    pub fn lights(&self, count: u32, seed: u64) -> Vec<EnvironmentLight> {
        let count = count.clamp(1, MOST) as usize;
        let mut random = Random::new(seed);
        match &self.tables {
            Tables::Density(density) if self.method == Method::Stratified => {
                stratified::lights(density, count, &mut random)
            }
            Tables::Density(density) => independent::lights(density, count, &mut random),
            Tables::Sums(sums) if self.method == Method::Regions => {
                regions::random(sums, count, &mut random)
            }
            Tables::Sums(sums) => regions::centred(sums, count, &mut random),
        }
    }
}
