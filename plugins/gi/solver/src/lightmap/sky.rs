//! A sky for few rays.

use std::{f32::consts::PI, sync::Arc};

use glam::Vec3;

use rayon::prelude::*;

use super::sequence::{hash2, unpack_direction};
use crate::scene::{Sky, SkyImage};

/// Columns of the soft image; half as many rows. A texel is about what one of a thousand rays of a
/// hemisphere stands for.
const WIDTH: u32 = 64;

/// The sky averaged over areas of about six degrees, so that a sun which few rays would find
/// reaches them all. What surfaces and probes gather from it stays the same in sum; shadows of the
/// sun are blurred by as much.
///
/// `before` is another sky and `soft_before` what this made of it: if both show the same image, as
/// when the sky only turns, it is not averaged again.
pub(crate) fn soft(sky: &Sky, before: &Sky, soft_before: &Sky) -> Sky {
    let Sky::Image { image, rotation, scale } = sky else { return sky.clone() };
    if let (Sky::Image { image: before, .. }, Sky::Image { image: soft, .. }) =
        (before, soft_before)
        && Arc::ptr_eq(image, before)
    {
        return Sky::Image { image: soft.clone(), rotation: *rotation, scale: *scale };
    }
    if image.width <= WIDTH || image.height <= WIDTH / 2 {
        return sky.clone();
    }
    let height = WIDTH / 2;
    let mut texels = vec![Vec3::ZERO; (WIDTH * height) as usize];
    let mut weights = vec![0.0_f32; texels.len()];
    for y in 0..image.height {
        // Solid angle of the row's texels, up to a factor.
        let solid = ((y as f32 + 0.5) / image.height as f32 * PI).sin();
        let row = (u64::from(y) * u64::from(height) / u64::from(image.height)) as u32;
        for x in 0..image.width {
            let column = (u64::from(x) * u64::from(WIDTH) / u64::from(image.width)) as u32;
            let to = (row * WIDTH + column) as usize;
            texels[to] += image.texels[(y * image.width + x) as usize] * solid;
            weights[to] += solid;
        }
    }
    for (texel, weight) in texels.iter_mut().zip(weights) {
        *texel /= weight;
    }
    let image = Arc::new(SkyImage { width: WIDTH, height, texels });
    Sky::Image { image, rotation: *rotation, scale: *scale }
}

/// Bits of an axis of a packed direction that tell the cell of a [`SkyTable`].
const CELL_BITS: u32 = 8;

/// A soft sky for kept rays, of which there are millions: its mean in cells of less than a degree, found
/// by packed direction without trigonometry.
pub(crate) enum SkyTable {
    Constant(Vec3),
    Cells(Vec<Vec3>),
}

impl Default for SkyTable {
    fn default() -> Self {
        Self::Constant(Vec3::ZERO)
    }
}

impl SkyTable {
    pub(crate) fn new(sky: &Sky) -> Self {
        match sky {
            Sky::Constant(radiance) => return Self::Constant(*radiance),
            Sky::Image { .. } if sky.is_black() => return Self::default(),
            Sky::Image { .. } => {}
        }
        let shift = 16 - CELL_BITS;
        let mean = |cell: u32| {
            let first = [cell & ((1 << CELL_BITS) - 1), cell >> CELL_BITS].map(|at| at << shift);
            let radiance = |x: u32, y: u32| {
                sky.radiance(unpack_direction((first[0] + x) | ((first[1] + y) << 16)))
            };
            let last = (1 << shift) - 1;
            let corners = [(0, 0), (last, 0), (0, last), (last, last)].map(|(x, y)| radiance(x, y));
            if corners.iter().all(|corner| *corner == corners[0]) {
                return corners[0];
            }
            // Edges of texels cross it. Points that are regular would make bright texels larger or
            // smaller than they are.
            let inside = |i: u32| {
                let (random, edge) = (hash2(cell, i), 1 << (shift - 2));
                let (x, y) = (random % edge, (random >> 16) % edge);
                radiance((i & 3) * edge + x, (i >> 2) * edge + y)
            };
            (0..16).map(inside).sum::<Vec3>() / 16.0
        };
        Self::Cells((0..1_u32 << (2 * CELL_BITS)).into_par_iter().map(mean).collect())
    }

    pub(crate) fn is_black(&self) -> bool {
        matches!(self, Self::Constant(Vec3::ZERO))
    }

    /// Radiance from a packed direction.
    pub(crate) fn radiance(&self, packed: u32) -> Vec3 {
        match self {
            Self::Constant(radiance) => *radiance,
            Self::Cells(cells) => {
                let shift = 16 - CELL_BITS;
                let (x, y) = ((packed & 0xffff) >> shift, packed >> (16 + shift));
                cells[((y << CELL_BITS) | x) as usize]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    #[test]
    fn a_table_holds_the_sky() {
        let texels = (0..64 * 32).map(|i| match i % 64 {
            20..23 if i / 64 == 7 => Vec3::new(200.0, 150.0, 100.0),
            x => Vec3::new(0.1, x as f32 * 0.01, (i / 64) as f32 * 0.1),
        });
        let image = Arc::new(SkyImage { width: 64, height: 32, texels: texels.collect() });
        let rotation = Quat::from_rotation_x(0.4) * Quat::from_rotation_y(1.0);
        let sky = Sky::Image { image, rotation, scale: 3.0 };
        let table = SkyTable::new(&sky);
        // By cosine around some normals: what irradiance is made of.
        let n = 1 << 20;
        for normal in [Vec3::Y, Vec3::X, Vec3::new(-1.0, 2.0, -0.5).normalize()] {
            let mean = |of: &dyn Fn(Vec3) -> Vec3| {
                let ray = |i| of(cosine_direction(sobol(i, 2), normal));
                (0..n).map(ray).sum::<Vec3>() / n as f32
            };
            let (exact, found) =
                (mean(&|d| sky.radiance(d)), mean(&|d| table.radiance(pack_direction(d))));
            // Cells on the edges of the bright spot are estimates, and so are these sums.
            assert!((found / exact - 1.0).abs().max_element() < 1.5e-2, "{found} {exact}");
        }
        assert!(SkyTable::new(&Sky::default()).is_black() && !table.is_black());
        assert_eq!(SkyTable::new(&Sky::Constant(Vec3::X)).radiance(12345), Vec3::X);
    }

    #[test]
    fn an_image_that_only_turns_is_averaged_once() {
        let image =
            Arc::new(SkyImage { width: 128, height: 64, texels: vec![Vec3::ONE; 128 * 64] });
        let turned = |turn| Sky::Image {
            image: image.clone(),
            rotation: Quat::from_rotation_y(turn),
            scale: turn,
        };
        let first = soft(&turned(1.0), &Sky::default(), &Sky::default());
        let second = soft(&turned(2.0), &turned(1.0), &first);
        let (Sky::Image { image: a, .. }, Sky::Image { image: b, rotation, scale }) =
            (&first, &second)
        else {
            panic!("an image stays one")
        };
        assert!(Arc::ptr_eq(a, b) && a.width == WIDTH);
        assert_eq!((*rotation, *scale), (Quat::from_rotation_y(2.0), 2.0));
    }

    use super::*;
    use crate::lightmap::sequence::{cosine_direction, pack_direction, sobol, sphere_direction};

    #[test]
    fn the_flux_stays() {
        let (width, height) = (256, 128);
        let mut texels = vec![Vec3::splat(0.5); (width * height) as usize];
        texels[30 * 256 + 100] = Vec3::new(9000.0, 8000.0, 7000.0);
        let image = Arc::new(SkyImage { width, height, texels });
        let sky = Sky::Image { image, rotation: Quat::IDENTITY, scale: 2.0 };
        // Exact integral of the sharp sky against cos^2 of the angle to an axis, texel by texel.
        let axis = Vec3::new(0.3, 0.8, 0.5).normalize();
        let Sky::Image { image, .. } = &sky else { unreachable!() };
        let mut sharp = Vec3::ZERO;
        for y in 0..height {
            let theta = (y as f32 + 0.5) / height as f32 * PI;
            for x in 0..width {
                let phi = ((x as f32 + 0.5) / width as f32 - 0.5) * 2.0 * PI;
                let d = Vec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
                let solid = theta.sin() * (PI / height as f32) * (2.0 * PI / width as f32);
                sharp += image.texels[(y * width + x) as usize] * solid * d.dot(axis).powi(2) * 2.0;
            }
        }
        let soft = soft(&sky, &Sky::default(), &Sky::default());
        let n = 1 << 16;
        let sum: Vec3 = (0..n)
            .map(|i| {
                let d = sphere_direction(sobol(i, 1));
                soft.radiance(d) * d.dot(axis).powi(2)
            })
            .sum();
        let blurred = sum * (4.0 * PI / n as f32);
        assert!((blurred / sharp - 1.0).abs().max_element() < 0.03, "{blurred} {sharp}");
    }
}
