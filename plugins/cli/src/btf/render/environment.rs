//! Light from everywhere: an equirectangular picture, and drawing directions towards its bright parts.

use std::f32::consts::{PI, TAU};
use std::path::Path;

use glam::{Vec2, Vec3};

use crate::error::CliError;

/// More texels than this are refused: 2^26.
const LIMIT: u64 = 1 << 26;

/// Radiance by direction. The centre of the picture is -z, its right half +x, its first row up.
pub(super) struct Environment {
    width: usize,
    height: usize,
    texels: Vec<Vec3>,
    /// Sum, up to and including each texel, of its brightest channel times its solid angle.
    sums: Vec<f64>,
}

impl Environment {
    /// Reads a Radiance picture (.hdr), or a PNG or JPEG as sRGB.
    pub(super) fn read(path: &Path) -> Result<Self, CliError> {
        let wrong = |what: String| CliError::new(format!("{}: {what}", path.display()));
        let open = || {
            let reader =
                image::ImageReader::open(path).map_err(|e| CliError::io(path, "read", &e))?;
            reader.with_guessed_format().map_err(|e| CliError::io(path, "read", &e))
        };
        let (width, height) = open()?.into_dimensions().map_err(|e| wrong(e.to_string()))?;
        if u64::from(width) * u64::from(height) > LIMIT {
            return Err(wrong(format!("{width} x {height} texels are more than {LIMIT}")));
        }
        let reader = open()?;
        let linear = reader.format() == Some(image::ImageFormat::Hdr);
        let picture = reader.decode().map_err(|e| wrong(e.to_string()))?.into_rgb32f();
        let texels: Vec<Vec3> = (picture.pixels())
            .map(|pixel| {
                let rgb = Vec3::from(pixel.0);
                if linear { rgb } else { rgb.map(farlight_btf_codec::linear) }
            })
            .collect();
        if texels.iter().any(|texel| !texel.is_finite() || texel.min_element() < 0.0) {
            return Err(wrong("holds a number that is no radiance".to_owned()));
        }
        let this = Self::new(width as usize, height as usize, texels);
        if this.total() > 0.0 { Ok(this) } else { Err(wrong("is all black".to_owned())) }
    }

    fn new(width: usize, height: usize, texels: Vec<Vec3>) -> Self {
        let mut sum = 0.0;
        let sums = (texels.iter().enumerate())
            .map(|(at, texel)| {
                let [top, bottom] = row_cosines(height, at / width);
                sum += f64::from(texel.max_element() * (top - bottom) * TAU / width as f32);
                sum
            })
            .collect();
        Self { width, height, texels, sums }
    }

    fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// Radiance from a direction, between texels interpolated.
    pub(super) fn radiance(&self, direction: Vec3) -> Vec3 {
        let at = self.place(direction) - 0.5;
        let (corner, part) = (at.floor(), at - at.floor());
        let texel = |x: f32, y: f32| {
            let x = (corner.x + x).rem_euclid(self.width as f32) as usize % self.width;
            let y = (corner.y + y).clamp(0.0, (self.height - 1) as f32) as usize;
            self.texels[y * self.width + x]
        };
        let top = texel(0.0, 0.0).lerp(texel(1.0, 0.0), part.x);
        let bottom = texel(0.0, 1.0).lerp(texel(1.0, 1.0), part.x);
        top.lerp(bottom, part.y)
    }

    /// Column and row in texels.
    fn place(&self, direction: Vec3) -> Vec2 {
        let u = 0.5 + direction.x.atan2(-direction.z) / TAU;
        let v = direction.y.clamp(-1.0, 1.0).acos() / PI;
        Vec2::new(u * self.width as f32, v * self.height as f32)
    }

    /// Draws a direction for a point of the unit square.
    pub(super) fn sample(&self, u: [f32; 2]) -> Vec3 {
        let target = f64::from(u[0]) * self.total();
        let texel = self.sums.partition_point(|sum| *sum <= target).min(self.texels.len() - 1);
        let from = if texel == 0 { 0.0 } else { self.sums[texel - 1] };
        let part = ((target - from) / (self.sums[texel] - from)).clamp(0.0, 1.0) as f32;
        let (column, row) = (texel % self.width, texel / self.width);
        let azimuth = ((column as f32 + part) / self.width as f32 - 0.5) * TAU;
        let [top, bottom] = row_cosines(self.height, row);
        let cos = top + (bottom - top) * u[1];
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        Vec3::new(sin * azimuth.sin(), cos, -sin * azimuth.cos())
    }

    /// The density per solid angle with which [`Environment::sample`] draws a direction.
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        let at = self.place(direction);
        let column = (at.x as usize).min(self.width - 1);
        let row = (at.y as usize).min(self.height - 1);
        let texel = row * self.width + column;
        (f64::from(self.texels[texel].max_element()) / self.total()) as f32
    }
}

/// Cosines of the polar angles at the upper and lower edge of a row.
fn row_cosines(height: usize, row: usize) -> [f32; 2] {
    [row, row + 1].map(|row| (PI * row as f32 / height as f32).cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made() -> Environment {
        let texel = |at: usize| Vec3::new((at % 7) as f32, 0.5, (at % 3) as f32 * 9.0);
        Environment::new(16, 8, (0..128).map(texel).collect())
    }

    #[test]
    fn directions_have_their_density() {
        let made = made();
        let (mut inverse, mut square) = (0.0, 0.0);
        let count = 10_000;
        for at in 0..count {
            let u = [(at as f32 + 0.5) / count as f32, (at as f32 * 0.618_034).fract()];
            let direction = made.sample(u);
            assert!((direction.length() - 1.0).abs() < 1e-4);
            let pdf = f64::from(made.pdf(direction));
            inverse += 1.0 / pdf / f64::from(count);
            square += f64::from(direction.y * direction.y) / pdf / f64::from(count);
        }
        // The means of 1 / pdf and y^2 / pdf are integrals over the sphere.
        let area = 4.0 * std::f64::consts::PI;
        assert!((inverse / area - 1.0).abs() < 0.02, "{inverse}");
        assert!((square / (area / 3.0) - 1.0).abs() < 0.02, "{square}");
    }

    #[test]
    fn the_picture_is_the_right_way_round() {
        let made = Environment::new(4, 2, (0..8).map(|at| Vec3::splat(at as f32)).collect());
        let at = |x: f32, y: f32, z: f32| made.radiance(Vec3::new(x, y, z).normalize()).x;
        // Centres of texels: columns -135, -45, 45 and 135 degrees from -z to +x, rows 45 degrees.
        let h = std::f32::consts::FRAC_1_SQRT_2;
        assert!((at(-h, 1.0, -h) - 1.0).abs() < 1e-3);
        assert!((at(h, 1.0, -h) - 2.0).abs() < 1e-3);
        assert!((at(h, -1.0, h) - 7.0).abs() < 1e-3);
    }
}
