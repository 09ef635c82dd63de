//! Equirectangular pictures as cube maps: the picture itself, mirrored light for each roughness, and
//! diffuse light, as Bevy's `EnvironmentMapLight` wants them. Without an engine's help, in a thread.

use std::{f32::consts::PI, path::Path};

use bevy::{
    asset::RenderAssetUsages,
    prelude::*,
    render::render_resource::{
        Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
    },
};
use half::f16;

/// Cube maps of one environment.
pub struct Cubes {
    /// What is seen behind the object.
    pub backdrop: Image,
    /// Radiance that arrives round a mirrored direction; a mip level for each roughness.
    pub specular: Image,
    /// Irradiance over pi.
    pub diffuse: Image,
}

/// Greatest width of a picture.
const MAX_WIDTH: u32 = 16_384;
/// Edge of the specular map, its levels, directions averaged for a texel.
const SPECULAR: u32 = 128;
const LEVELS: u32 = 6;
const SAMPLES: u32 = 64;
/// Edge of the diffuse map.
const DIFFUSE: u32 = 16;

/// One level of a picture: linear values, rows from the top.
struct Level {
    width: usize,
    height: usize,
    texels: Vec<Vec3>,
}

/// Reads a picture and makes its cube maps.
pub fn read(path: &Path) -> Result<Cubes, String> {
    let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let mut reader = image::ImageReader::open(path).map_err(|e| wrong(&e))?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_WIDTH);
    limits.max_image_height = Some(MAX_WIDTH / 2);
    limits.max_alloc = Some(2 << 30);
    reader.limits(limits);
    let picture = reader
        .with_guessed_format()
        .map_err(|e| wrong(&e))?
        .decode()
        .map_err(|e| wrong(&e))?
        .into_rgb32f();
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    if width < 4 || width != 2 * height {
        return Err(wrong(&format!("{width}x{height} is not twice as wide as high")));
    }
    // What a half float holds; not-a-number becomes black.
    let value = |v: f32| if v > 0.0 { v.min(60_000.0) } else { 0.0 };
    let texels = picture.pixels().map(|p| Vec3::from(p.0.map(value))).collect();
    Ok(cubes(Level { width, height, texels }))
}

fn cubes(picture: Level) -> Cubes {
    let mut levels = vec![picture];
    while levels[levels.len() - 1].height > 4 {
        levels.push(levels[levels.len() - 1].halved());
    }
    let face = (levels[0].width as u32 / 4).next_power_of_two().clamp(64, 1024);
    let sharp = |direction| levels[0].at(direction);
    let backdrop = cube(face, 1, |_, direction| sharp(direction));
    let specular = cube(SPECULAR, LEVELS, |level, direction| {
        blurred(&levels, direction, level as f32 / (LEVELS - 1) as f32)
    });
    let coarse = levels.iter().find(|level| level.width <= 64).unwrap_or(&levels[levels.len() - 1]);
    let rays = coarse.rays();
    let diffuse = cube(DIFFUSE, 1, |_, normal| {
        let sum: Vec3 = rays.iter().map(|(d, light)| *light * normal.dot(*d).max(0.0)).sum();
        sum / PI
    });
    Cubes { backdrop, specular, diffuse }
}

/// Radiance round a direction, weighted as by a rough mirror seen head-on (GGX, filtered importance
/// sampling: Křivánek and Colbert, *Real-time Shading with Filtered Importance Sampling*, 2008).
fn blurred(levels: &[Level], direction: Vec3, roughness: f32) -> Vec3 {
    let alpha = roughness * roughness;
    if alpha < 1e-3 {
        return sample(levels, direction, 0.0);
    }
    let (x, y) = direction.any_orthonormal_pair();
    let texel = 4.0 * PI / (levels[0].width * levels[0].height) as f32;
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
        sum += sample(levels, light, level) * weight;
        weights += weight;
    }
    sum / weights.max(1e-6)
}

/// Between two levels.
fn sample(levels: &[Level], direction: Vec3, level: f32) -> Vec3 {
    let level = level.clamp(0.0, (levels.len() - 1) as f32);
    let low = level as usize;
    let high = (low + 1).min(levels.len() - 1);
    levels[low].at(direction).lerp(levels[high].at(direction), level - low as f32)
}

impl Level {
    /// `u = 0.5 + atan2(x, -z) / 2π`, `v = acos(y) / π`; bilinear.
    fn at(&self, d: Vec3) -> Vec3 {
        let u = 0.5 + d.x.atan2(-d.z) / (2.0 * PI);
        let v = d.y.clamp(-1.0, 1.0).acos() / PI;
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let texel = |dx: i32, dy: i32| {
            let x = (x.floor() as i32 + dx).rem_euclid(self.width as i32) as usize;
            let y = (y.floor() as i32 + dy).clamp(0, self.height as i32 - 1) as usize;
            self.texels[y * self.width + x]
        };
        texel(0, 0).lerp(texel(1, 0), fx).lerp(texel(0, 1).lerp(texel(1, 1), fx), fy)
    }

    /// Half as wide and as high; rows weigh as much as the sky that they cover.
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut texels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let x = (2 * x + dx).min(self.width - 1);
                    let y = (2 * y + dy).min(self.height - 1);
                    let weight = (PI * (y as f32 + 0.5) / self.height as f32).sin();
                    sum += self.texels[y * self.width + x] * weight;
                    weights += weight;
                }
                texels.push(sum / weights);
            }
        }
        Self { width, height, texels }
    }

    /// Direction of each texel, its radiance times its solid angle.
    fn rays(&self) -> Vec<(Vec3, Vec3)> {
        let mut rays = Vec::with_capacity(self.texels.len());
        for y in 0..self.height {
            let (low, high) = (y as f32, y as f32 + 1.0);
            let edge = |row: f32| (PI * row / self.height as f32).cos();
            let solid_angle = (edge(low) - edge(high)) * 2.0 * PI / self.width as f32;
            let polar = PI * (y as f32 + 0.5) / self.height as f32;
            for x in 0..self.width {
                let turn = 2.0 * PI * ((x as f32 + 0.5) / self.width as f32 - 0.5);
                let d = Vec3::new(polar.sin() * turn.sin(), polar.cos(), -polar.sin() * turn.cos());
                rays.push((d, self.texels[y * self.width + x] * solid_angle));
            }
        }
        rays
    }
}

/// A cube map of a function of mip level and direction.
fn cube(edge: u32, levels: u32, light: impl Fn(u32, Vec3) -> Vec3) -> Image {
    let mut data = Vec::new();
    // Faces one after the other, each with its levels.
    for face in 0..6 {
        for level in 0..levels {
            let edge = edge >> level;
            for y in 0..edge {
                for x in 0..edge {
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
                    // Cube maps are left-handed; Bevy looks them up with z turned round.
                    let direction = (in_cube * Vec3::new(1.0, 1.0, -1.0)).normalize();
                    let [r, g, b] = light(level, direction).to_array();
                    for value in [r, g, b, 1.0] {
                        data.extend(f16::from_f32(value).to_le_bytes());
                    }
                }
            }
        }
    }
    let mut image = Image::new_uninit(
        Extent3d { width: edge, height: edge, depth_or_array_layers: 6 },
        TextureDimension::D2,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.mip_level_count = levels;
    image.texture_view_descriptor =
        Some(TextureViewDescriptor { dimension: Some(TextureViewDimension::Cube), ..default() });
    image.data = Some(data);
    image
}
