//! What a surface reflects of a whole environment: the sum over its texels.

use std::{f64::consts::TAU, thread};

use bevy::math::{DQuat, DVec3, Quat};
use farlight_environment::{Environment, EnvironmentLight};

use super::{
    ball::Seen,
    shading::{Reflection, Surface},
};

/// A directional light.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Unit vector towards it.
    pub towards: DVec3,
    /// On a plane that faces it.
    pub irradiance: DVec3,
}

/// How finely an environment is summed up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grain {
    /// Each texel is cut into this many columns and rows.
    Split(usize),
    /// As many columns and rows of texels are one light from their mean direction, weighted by
    /// luminance, with their whole energy.
    Merged(usize),
}

impl Grain {
    /// A light a texel.
    pub const TEXEL: Self = Self::Split(1);
}

/// Radiance of points of a surface under the whole environment, turned by `rotation`, without shadows.
pub fn environment_reference(
    surface: &Surface,
    environment: &Environment,
    rotation: Quat,
    grain: Grain,
    points: &[Seen],
) -> Vec<DVec3> {
    lit_by(surface, &rays(environment, rotation, grain), points)
}

/// An environment as many lights.
pub fn rays(environment: &Environment, rotation: Quat, grain: Grain) -> Vec<Ray> {
    let (split, merged) = match grain {
        Grain::Split(n) => (n, 1),
        Grain::Merged(n) => (1, n),
    };
    let turn = rotation.as_dquat().normalize();
    let [columns, rows] = [environment.width(), environment.height()].map(|n| n as usize * split);
    let mut rays = Vec::new();
    for top in (0..rows).step_by(merged) {
        for left in (0..columns).step_by(merged) {
            let (mut mean, mut energy) = (DVec3::ZERO, DVec3::ZERO);
            for y in top..(top + merged).min(rows) {
                // Equal parts of the cell's height in cos(theta) lie below and above its middle.
                let [above, below] = [y, y + 1].map(|y| (TAU / 2.0 * y as f64 / rows as f64).cos());
                let solid_angle = (above - below) * TAU / columns as f64;
                let height = (above + below) / 2.0;
                let flat = (1.0 - height * height).max(0.0).sqrt();
                for x in left..(left + merged).min(columns) {
                    let azimuth = TAU * ((x as f64 + 0.5) / columns as f64 - 0.5);
                    let at = y / split * environment.width() as usize + x / split;
                    let light = environment.texels()[at].as_dvec3() * solid_angle;
                    let direction = DVec3::new(flat * azimuth.sin(), height, -flat * azimuth.cos());
                    mean += direction * light.dot(DVec3::new(0.2126, 0.7152, 0.0722));
                    energy += light;
                }
            }
            if energy != DVec3::ZERO {
                rays.push(Ray { towards: turn * mean.normalize(), irradiance: energy });
            }
        }
    }
    rays
}

/// Lights of an environment that is turned.
pub fn turned(lights: &[EnvironmentLight], rotation: Quat) -> Vec<Ray> {
    let turn: DQuat = rotation.as_dquat().normalize();
    let ray = |light: &EnvironmentLight| Ray {
        towards: turn * light.direction.as_dvec3().normalize(),
        irradiance: light.irradiance.as_dvec3(),
    };
    lights.iter().map(ray).collect()
}

/// Radiance of points of a surface under lights, on all cores.
pub fn lit_by(surface: &Surface, rays: &[Ray], points: &[Seen]) -> Vec<DVec3> {
    let cores = thread::available_parallelism().map_or(1, |n| n.get());
    let share = points.len().div_ceil(cores).max(1);
    let sum = |point: &Seen| {
        let reflection = Reflection::new(surface, point.normal, point.view);
        rays.iter().map(|ray| reflection.towards_view(ray.towards) * ray.irradiance).sum()
    };
    thread::scope(|scope| {
        let parts: Vec<_> = points
            .chunks(share)
            .map(|part| scope.spawn(move || part.iter().map(sum).collect::<Vec<DVec3>>()))
            .collect();
        parts.into_iter().flat_map(|part| part.join().unwrap()).collect()
    })
}
