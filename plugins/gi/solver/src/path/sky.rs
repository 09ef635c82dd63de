//! Directions towards the bright parts of a sky image.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3};

use super::table::Table;
use crate::{
    sampling::PathSampler,
    scene::{Sky, SkyImage},
};

/// Texels of the sky image, drawn by solid angle times their largest channel.
pub(super) struct SkyTexels<'w> {
    table: Table,
    image: &'w SkyImage,
    rotation: Quat,
    back: Quat,
}

/// A direction in the sky.
pub(super) struct SkySample {
    /// Unit vector, away from the receiver.
    pub(super) direction: Vec3,
    /// Density per solid angle with which it is drawn.
    pub(super) pdf: f32,
}

impl<'w> SkyTexels<'w> {
    /// `None` for a constant sky, for which drawing directions towards it gains nothing, and for a
    /// black one.
    pub(super) fn new(sky: &'w Sky) -> Option<Self> {
        let Sky::Image { image, rotation, .. } = sky else { return None };
        if sky.is_black() || image.texels.len() != image.width as usize * image.height as usize {
            return None;
        }
        let weights = (0..image.height).flat_map(|y| {
            let solid_angle = texel_solid_angle(image, y);
            let row = (y * image.width) as usize..((y + 1) * image.width) as usize;
            image.texels[row].iter().map(move |texel| texel.max_element() * solid_angle)
        });
        let table = Table::new(weights);
        (!table.is_empty()).then(|| Self {
            table,
            image,
            rotation: *rotation,
            back: rotation.inverse(),
        })
    }

    /// Draws a direction.
    pub(super) fn sample(&self, sampler: &mut PathSampler) -> SkySample {
        let (texel, u) = self.table.sample(sampler);
        let (x, y) = (texel as u32 % self.image.width, texel as u32 / self.image.width);
        let azimuth = ((x as f32 + u.x) / self.image.width as f32 - 0.5) * TAU;
        let (top, bottom) = row_cosines(self.image, y);
        let cos = top + (bottom - top) * u.y;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let local = Vec3::new(sin * azimuth.sin(), cos, -sin * azimuth.cos());
        SkySample { direction: self.rotation * local, pdf: self.texel_pdf(x, y) }
    }

    /// Density per solid angle with which [`sample`](Self::sample) draws a unit direction.
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        let (x, y) = self.image.texel_at(self.back * direction);
        self.texel_pdf(x, y)
    }

    fn texel_pdf(&self, x: u32, y: u32) -> f32 {
        let weight = self.image.texels[(y * self.image.width + x) as usize].max_element();
        // weight * solid angle / total / solid angle.
        (f64::from(weight.max(0.0)) / self.table.total()) as f32
    }
}

/// Cosines of the polar angles at the upper and lower edge of a row.
fn row_cosines(image: &SkyImage, y: u32) -> (f32, f32) {
    let cos = |row: u32| (PI * row as f32 / image.height as f32).cos();
    (cos(y), cos(y + 1))
}

fn texel_solid_angle(image: &SkyImage, y: u32) -> f32 {
    let (top, bottom) = row_cosines(image, y);
    TAU / image.width as f32 * (top - bottom)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::sampling::{Rng, uniform_sphere};

    fn sky() -> Sky {
        let mut rng = Rng::new(1, 0);
        let texels = (0..16 * 8).map(|i| {
            let value = rng.next_f32().powi(4) * if i % 5 == 0 { 0.0 } else { 1.0 };
            Vec3::new(value, 0.5 * value, 0.2 * value)
        });
        Sky::Image {
            image: Arc::new(SkyImage { width: 16, height: 8, texels: texels.collect() }),
            rotation: Quat::from_rotation_x(0.7) * Quat::from_rotation_y(2.0),
            scale: 3.0,
        }
    }

    /// The density integrates to 1 and is what directions are drawn with.
    #[test]
    fn directions_have_their_density() {
        let sky = sky();
        let texels = SkyTexels::new(&sky).unwrap();
        let n = 100_000_u32;
        let mut rng = Rng::new(2, 0);
        let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
        for _ in 0..n {
            let pdf = f64::from(texels.pdf(uniform_sphere(rng.next_2d().into())));
            sum += pdf;
            squares += pdf * pdf;
        }
        let n = f64::from(n);
        let (mean, area) = (sum / n, 4.0 * std::f64::consts::PI);
        let se = ((squares / n - mean * mean) / n).sqrt();
        assert!((mean * area - 1.0).abs() < 4.5 * se * area, "{}", mean * area);

        // E over the sphere of radiance, with either kind of direction.
        let mut others = 0;
        let (mut by_sky, mut by_sphere) = ([0.0_f64; 2], [0.0_f64; 2]);
        for i in 0..100_000 {
            let mut sampler = PathSampler::new(3, i, 0);
            let s = texels.sample(&mut sampler);
            assert!((s.direction.length() - 1.0).abs() < 1e-4);
            // At a texel's edge rounding may tell the neighbour.
            others += u32::from(texels.pdf(s.direction) != s.pdf);
            let weigh = |d: Vec3| f64::from(sky.radiance(d).x * (1.0 + d.x + d.y * d.z));
            let x = weigh(s.direction) / f64::from(s.pdf);
            by_sky[0] += x;
            by_sky[1] += x * x;
            let y = weigh(uniform_sphere(rng.next_2d().into())) * area;
            by_sphere[0] += y;
            by_sphere[1] += y * y;
        }
        assert!(others < 10, "{others}");
        let variance = |s: [f64; 2]| (s[1] / n - (s[0] / n).powi(2)) / n;
        let z = (by_sky[0] - by_sphere[0]) / n / (variance(by_sky) + variance(by_sphere)).sqrt();
        assert!(z.abs() < 4.5, "{by_sky:?} {by_sphere:?}");
        assert!(variance(by_sky) < variance(by_sphere), "drawing by brightness is worth it");
    }

    #[test]
    fn plain_skies_have_no_table() {
        assert!(SkyTexels::new(&Sky::Constant(Vec3::ONE)).is_none());
        let black = Sky::Image {
            image: Arc::new(SkyImage { width: 2, height: 1, texels: vec![Vec3::ZERO; 2] }),
            rotation: Quat::IDENTITY,
            scale: 1.0,
        };
        assert!(SkyTexels::new(&black).is_none());
    }
}
