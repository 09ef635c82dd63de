//! A picture of the cloth from a few directions, before it is compressed.

use std::path::Path;

use farlight_btf_codec::compress::Grid;
use image::{Rgb, RgbImage};

use crate::measure::{Lights, STEPS, view};
use crate::transport::Cloth;

/// Views (phi, theta) down, lights (alpha, beta) across.
const VIEWS: [[usize; 2]; 4] = [[0, 0], [0, 3], [12, 4], [2, 5]];
const LIGHTS: [[usize; 2]; 5] = [[5, 5], [2, 5], [5, 1], [7, 6], [8, 5]];
/// Tiles and pixels a texel.
const REPEAT: usize = 2;
const ZOOM: usize = 2;

pub(crate) fn write(
    path: &Path,
    cloth: &Cloth,
    grid: &Grid,
    texels: usize,
    samples: u32,
) -> Result<(), String> {
    let cell = texels * REPEAT * ZOOM;
    let size = [LIGHTS.len(), VIEWS.len()].map(|count| (count * (cell + 8)) as u32);
    let mut picture = RgbImage::new(size[0], size[1]);
    for (row, [phi, theta]) in VIEWS.into_iter().enumerate() {
        let lights = Lights::new(cloth, grid, phi);
        let values = view(cloth, grid, &lights, [phi, theta], texels, samples);
        for (column, [alpha, beta]) in LIGHTS.into_iter().enumerate() {
            for y in 0..cell {
                for x in 0..cell {
                    let texel = (y / ZOOM % texels) * texels + x / ZOOM % texels;
                    let light = alpha * grid.beta + beta;
                    let value = values[texel * grid.alpha * grid.beta + light];
                    let rgb = value.map(|v| (f32::from(v) / STEPS).round().min(255.0) as u8);
                    let at = [column * (cell + 8) + x, row * (cell + 8) + y];
                    picture.put_pixel(at[0] as u32, at[1] as u32, Rgb(rgb));
                }
            }
        }
    }
    picture.save(path).map_err(|error| format!("{}: {error}", path.display()))
}
