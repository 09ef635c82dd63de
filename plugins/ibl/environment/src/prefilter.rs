//! Cube maps of a map: the map itself, what rough mirrors show of it, and what lights matte surfaces.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

use crate::{Environment, sphere};

/// Directions that are averaged for a texel of a rough mirror's map.
const SAMPLES: u32 = 64;
/// Width of the map, at most, that matte light is summed over.
const COARSE: usize = 64;

/// A cube map of linear radiance: faces +X, -X, +Y, -Y, +Z, -Z one after the other, each with its mip
/// levels, each level row by row from the top.
///
/// Graphics interfaces have left-handed cubes. A direction of the (right-handed) map is found in them
/// with its z turned round, as Bevy looks it up.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMap {
    /// Texels along an edge of the first level.
    pub edge: u32,
    /// Mip levels, each half as large as the one before.
    pub levels: u32,
    /// Radiance.
    pub texels: Vec<Vec3>,
}

impl Environment {
    /// The map as a cube, between texels linear: what is seen of it. An edge of a quarter of the map's
    /// width keeps what there is to see.
    #[must_use]
    pub fn cube(&self, edge: u32) -> CubeMap {
        let sharp = Level::of(self);
        CubeMap::new(edge, 1, |_, direction| sharp.at(direction))
    }

    /// What mirrors show, seen head-on: perceptual roughness 0 in the first level, 1 in the last, evenly
    /// between them. `levels` is 1 or more.
    ///
    /// GGX by filtered importance sampling (Křivánek and Colbert, *Real-time Shading with Filtered
    /// Importance Sampling*, 2008), 64 directions a texel.
    #[must_use]
    pub fn specular_cube(&self, edge: u32, levels: u32) -> CubeMap {
        let pyramid = pyramid(self);
        let last = levels.saturating_sub(1).max(1) as f32;
        CubeMap::new(edge, levels, |level, direction| {
            rough(&pyramid, direction, level as f32 / last)
        })
    }

    /// What lights matte surfaces: irradiance over pi, for each normal.
    #[must_use]
    pub fn diffuse_cube(&self, edge: u32) -> CubeMap {
        let pyramid = pyramid(self);
        let coarse = pyramid.iter().find(|level| level.width <= COARSE);
        let rays = coarse.unwrap_or(&pyramid[pyramid.len() - 1]).rays();
        CubeMap::new(edge, 1, |_, normal| {
            let sum: Vec3 = rays.iter().map(|(d, light)| *light * normal.dot(*d).max(0.0)).sum();
            sum / PI
        })
    }
}

impl CubeMap {
    fn new(edge: u32, levels: u32, light: impl Fn(u32, Vec3) -> Vec3 + Sync) -> Self {
        let edge = edge.max(1);
        let levels = levels.clamp(1, edge.ilog2() + 1);
        let rows: Vec<(u32, u32, u32)> = (0..6)
            .flat_map(|face| (0..levels).map(move |level| (face, level)))
            .flat_map(|(face, level)| (0..edge >> level).map(move |y| (face, level, y)))
            .collect();
        let texels = rows
            .into_par_iter()
            .flat_map_iter(|(face, level, y)| {
                let (edge, light) = (edge >> level, &light);
                (0..edge).map(move |x| light(level, direction(face, [x, y], edge)))
            })
            .collect();
        Self { edge, levels, texels }
    }
}

/// The direction of the middle of a cube's texel.
fn direction(face: u32, [x, y]: [u32; 2], edge: u32) -> Vec3 {
    let s = (2 * x + 1) as f32 / edge as f32 - 1.0;
    let t = (2 * y + 1) as f32 / edge as f32 - 1.0;
    let in_cube = match face {
        0 => Vec3::new(1.0, -t, -s),
        1 => Vec3::new(-1.0, -t, s),
        2 => Vec3::new(s, 1.0, t),
        3 => Vec3::new(s, -1.0, -t),
        4 => Vec3::new(s, -t, 1.0),
        _ => Vec3::new(-s, -t, -1.0),
    };
    (in_cube * Vec3::new(1.0, 1.0, -1.0)).normalize()
}

/// One level of a map's pyramid.
struct Level {
    width: usize,
    height: usize,
    texels: Vec<Vec3>,
}

fn pyramid(map: &Environment) -> Vec<Level> {
    let mut levels = vec![Level::of(map)];
    while let Some(last) = levels.last().filter(|level| level.height > 4) {
        let next = last.halved();
        levels.push(next);
    }
    levels
}

/// Radiance round a direction, weighted as by a rough mirror seen head-on.
fn rough(pyramid: &[Level], direction: Vec3, roughness: f32) -> Vec3 {
    let alpha = roughness * roughness;
    if alpha < 1e-3 {
        return between(pyramid, direction, 0.0);
    }
    let (x, y) = direction.any_orthonormal_pair();
    let texel = 4.0 * PI / (pyramid[0].width * pyramid[0].height) as f32;
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for i in 0..SAMPLES {
        let u = (i as f32 + 0.5) / SAMPLES as f32;
        let v = (i.reverse_bits() >> 8) as f32 / (1 << 24) as f32;
        let cosine = ((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u)).sqrt();
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (s, c) = (2.0 * PI * v).sin_cos();
        let half = x * (sine * c) + y * (sine * s) + direction * cosine;
        let light = 2.0 * direction.dot(half) * half - direction;
        let weight = direction.dot(light);
        if weight <= 0.0 {
            continue;
        }
        let d = cosine * cosine * (alpha * alpha - 1.0) + 1.0;
        let density = alpha * alpha / (PI * d * d) / 4.0;
        let solid_angle = 1.0 / (SAMPLES as f32 * density);
        let level = (0.5 * (solid_angle / texel).log2() + 1.0).max(0.0);
        sum += between(pyramid, light, level) * weight;
        weights += weight;
    }
    sum / weights.max(1e-6)
}

/// Between two levels.
fn between(pyramid: &[Level], direction: Vec3, level: f32) -> Vec3 {
    let level = level.clamp(0.0, (pyramid.len() - 1) as f32);
    let low = level as usize;
    let high = (low + 1).min(pyramid.len() - 1);
    pyramid[low].at(direction).lerp(pyramid[high].at(direction), level - low as f32)
}

impl Level {
    fn of(map: &Environment) -> Self {
        let (width, height) = (map.width() as usize, map.height() as usize);
        Self { width, height, texels: map.texels().to_vec() }
    }

    /// Radiance in a direction, linear between texels.
    fn at(&self, direction: Vec3) -> Vec3 {
        let place = sphere::place(direction.as_dvec3(), self.width, self.height).as_vec2() - 0.5;
        let (corner, t) = (place.floor(), place - place.floor());
        let texel = |dx: i32, dy: i32| {
            let x = (corner.x as i32 + dx).rem_euclid(self.width as i32) as usize;
            let y = (corner.y as i32 + dy).clamp(0, self.height as i32 - 1) as usize;
            self.texels[y * self.width + x]
        };
        texel(0, 0).lerp(texel(1, 0), t.x).lerp(texel(0, 1).lerp(texel(1, 1), t.x), t.y)
    }

    /// Half as wide and as high; rows weigh as much as the sky that they cover.
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let row = |y: usize| {
            (0..width).map(move |x| {
                let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let x = (2 * x + dx).min(self.width - 1);
                    let y = (2 * y + dy).min(self.height - 1);
                    let weight = (PI * (y as f32 + 0.5) / self.height as f32).sin();
                    sum += self.texels[y * self.width + x] * weight;
                    weights += weight;
                }
                sum / weights
            })
        };
        Self { width, height, texels: (0..height).into_par_iter().flat_map_iter(row).collect() }
    }

    /// Direction of each texel, its radiance times its solid angle.
    fn rays(&self) -> Vec<(Vec3, Vec3)> {
        let edges = sphere::row_edges(self.height);
        let mut rays = Vec::with_capacity(self.texels.len());
        for (y, row) in self.texels.chunks_exact(self.width).enumerate() {
            let solid_angle = (edges[y] - edges[y + 1]) as f32 * 2.0 * PI / self.width as f32;
            let middle = 0.5 * (edges[y] + edges[y + 1]);
            for (x, radiance) in row.iter().enumerate() {
                let azimuth = sphere::azimuth(x as f64 + 0.5, self.width);
                let direction = sphere::direction(azimuth, middle).as_vec3();
                rays.push((direction, *radiance * solid_angle));
            }
        }
        rays
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bright sky over dark ground, with a warm patch to the right.
    fn map() -> Environment {
        let texels = (0..64 * 32)
            .map(|i| match (i % 64, i / 64) {
                (44..52, 8..16) => Vec3::new(9.0, 6.0, 3.0),
                (_, 0..16) => Vec3::new(0.5, 0.7, 1.0),
                _ => Vec3::splat(0.1),
            })
            .collect();
        Environment::from_equirect(64, 32, texels).unwrap()
    }

    fn in_direction(cube: &CubeMap, level: u32, towards: Vec3) -> Vec3 {
        let edge = cube.edge >> level;
        let mut best = (f32::MIN, Vec3::ZERO);
        let mut at = 0;
        for face in 0..6 {
            for l in 0..cube.levels {
                for i in 0..(cube.edge >> l) * (cube.edge >> l) {
                    let likeness = direction(face, [i % edge, i / edge], edge).dot(towards);
                    if l == level && likeness > best.0 {
                        best = (likeness, cube.texels[at]);
                    }
                    at += 1;
                }
            }
        }
        assert_eq!(at, cube.texels.len());
        best.1
    }

    #[test]
    fn a_cube_shows_each_direction_where_the_map_has_it() {
        let (map, cube) = (map(), map().cube(32));
        for towards in [
            Vec3::new(0.2, 0.9, 0.1),
            Vec3::new(1.0, 0.4, 0.0),
            Vec3::new(-0.5, 0.3, 0.8),
            Vec3::new(0.1, -0.7, -0.4),
        ] {
            let (seen, there) = (in_direction(&cube, 0, towards), map.radiance(towards));
            assert!((seen - there).length() < 1e-3, "{towards}: {seen} {there}");
        }
    }

    #[test]
    fn matte_light_is_the_irradiance_over_pi() {
        let (map, cube) = (map(), map().diffuse_cube(8));
        for face in 0..6 {
            for texel in [[0, 0], [3, 4], [7, 2]] {
                let exact = map.irradiance(direction(face, texel, 8)) / PI;
                let at = (face * 64 + texel[1] * 8 + texel[0]) as usize;
                // Sums over 64 x 32 directions.
                let apart = (cube.texels[at] - exact).length() / exact.length();
                assert!(apart < 0.01, "{} for {exact}", cube.texels[at]);
            }
        }
    }

    #[test]
    fn a_rougher_mirror_shows_less_and_a_uniform_map_stays_uniform() {
        let cube = map().specular_cube(16, 4);
        let patch = Vec3::new(1.0, 0.4, 0.0);
        let shown: Vec<f32> = (0..4).map(|level| in_direction(&cube, level, patch).x).collect();
        assert!(shown.windows(2).all(|pair| pair[1] < pair[0]), "{shown:?}");
        let even = Environment::from_equirect(16, 8, vec![Vec3::splat(2.0); 128]).unwrap();
        for texel in even.specular_cube(8, 3).texels {
            assert!((texel - 2.0).abs().max_element() < 1e-4, "{texel}");
        }
        assert_eq!(map().specular_cube(4, 9).levels, 3, "as many as there can be");
        let one = Environment::from_equirect(1, 1, vec![Vec3::ONE]).unwrap();
        assert_eq!(one.cube(2).texels, vec![Vec3::ONE; 24]);
    }
}
