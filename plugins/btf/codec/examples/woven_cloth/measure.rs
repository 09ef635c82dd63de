//! The cloth as a measuring rig would see it: each texel, each view, each light.

use std::f32::consts::FRAC_PI_2;

use farlight_btf_codec::{compress::Grid, srgb_encode};
use glam::Vec3;
use rayon::prelude::*;

use crate::transport::{Arriving, Cloth, blurred, sights};
use crate::weave::TILE;

/// Samples with a light or a view at 90 degrees hold what is there at these elevations: what lies
/// between the last two samples counts, and the picture runs away where the view grazes the cloth.
const LIMIT: Limits = Limits { light: 84.0 / 90.0 * FRAC_PI_2, view: 79.0 / 90.0 * FRAC_PI_2 };

struct Limits {
    light: f32,
    view: f32,
}

/// Steps of the stored values in 1 of 255.
pub(crate) const STEPS: f32 = 64.0;

/// Directions with their texels: gamma-encoded, 255 for white, times [`STEPS`].
pub(crate) type Value = [u16; 3];

/// All lights of an azimuth of the view.
pub(crate) struct Lights {
    directions: Vec<Vec3>,
    /// For each alpha and beta.
    index: Vec<usize>,
    arriving: Arriving,
}

impl Lights {
    pub(crate) fn new(cloth: &Cloth, grid: &Grid, phi: usize) -> Self {
        let mut directions: Vec<Vec3> = Vec::new();
        let mut index = Vec::new();
        for alpha in 0..grid.alpha {
            for beta in 0..grid.beta {
                let angles = grid.angles(phi, 0, alpha, beta);
                let light = direction(angles.theta_i.min(LIMIT.light), angles.phi_i);
                let known = directions.iter().position(|d| d.distance(light) < 1e-4);
                index.push(known.unwrap_or_else(|| {
                    directions.push(light);
                    directions.len() - 1
                }));
            }
        }
        Self { arriving: cloth.arriving(&directions), directions, index }
    }

    /// The same lights for the view from the other side, to which they stand the other way round.
    pub(crate) fn opposite(mut self) -> Self {
        self.index.reverse();
        self
    }
}

fn direction(theta: f32, phi: f32) -> Vec3 {
    let (sin, cos) = theta.sin_cos();
    Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// One view: for each texel, each alpha and beta.
pub(crate) fn view(
    cloth: &Cloth,
    grid: &Grid,
    lights: &Lights,
    [phi, theta]: [usize; 2],
    texels: usize,
    count: u32,
) -> Vec<Value> {
    let [theta_v, phi_v] = grid.view(phi, theta);
    let view = direction(theta_v.min(LIMIT.view), phi_v);
    // The plane whose points keep their place in the picture whatever the view.
    let [low, high] = cloth.mesh.heights;
    let middle = low + 0.8 * (high - low);
    let pitch = TILE / texels as f32;
    let slice = lights.index.len();
    let sights = sights(count);
    let mut values = vec![[0; 3]; texels * texels * slice];
    values.par_chunks_mut(slice).enumerate().for_each(|(texel, values)| {
        let corner = [texel % texels, texel / texels].map(|at| at as f32);
        let mut sum = vec![Vec3::ZERO; lights.directions.len()];
        for [point, shift] in &sights {
            let view = blurred(view, *shift);
            // Rows count against y.
            let place = Vec3::new(
                (corner[0] + point.x) * pitch,
                TILE - (corner[1] + point.y) * pitch,
                middle,
            );
            if let Some(place) = cloth.seen(place, view) {
                cloth.shade(place, view, &lights.directions, &lights.arriving, &mut sum);
            }
        }
        for (value, light) in values.iter_mut().zip(&lights.index) {
            let encoded = (sum[*light] / count as f32).map(srgb_encode) * 255.0 * STEPS;
            *value = encoded.to_array().map(|channel| channel.round() as u16);
        }
    });
    values
}
