//! A picture of a map, with its lights.

use std::f32::consts::{PI, TAU};
use std::io::Cursor;

use farlight_btf_codec::srgb_encode;
use farlight_environment::{Environment, EnvironmentLight};
use glam::{Vec2, Vec3};
use image::{Rgb, RgbImage};

use crate::error::CliError;

/// Columns of a picture.
const WIDTH: u32 = 1024;
/// Samples a pixel, each way.
const SAMPLES: u32 = 2;
/// Share of the picture that is brighter than white.
const WHITE: f32 = 0.02;

/// A PNG of the map, its brightest parts white, with a dot at each light.
pub(super) fn draw(map: &Environment, lights: &[EnvironmentLight]) -> Result<Vec<u8>, CliError> {
    let [width, height] = [WIDTH, WIDTH / 2];
    let radiance = |x: u32, y: u32| {
        let samples = (0..SAMPLES * SAMPLES).map(|sample| {
            let part =
                [sample % SAMPLES, sample / SAMPLES].map(|at| (at as f32 + 0.5) / SAMPLES as f32);
            let azimuth = ((x as f32 + part[0]) / width as f32 - 0.5) * TAU;
            let (sin, cos) = ((y as f32 + part[1]) / height as f32 * PI).sin_cos();
            map.radiance(Vec3::new(sin * azimuth.sin(), cos, -sin * azimuth.cos()))
        });
        samples.sum::<Vec3>() / (SAMPLES * SAMPLES) as f32
    };
    let pixels: Vec<Vec3> =
        (0..width * height).map(|at| radiance(at % width, at / width)).collect();
    let mut greatest: Vec<f32> = pixels.iter().map(|pixel| pixel.max_element()).collect();
    greatest.sort_by(f32::total_cmp);
    let white = greatest[((1.0 - WHITE) * greatest.len() as f32) as usize];
    let scale = if white > 0.0 { white.recip() } else { 1.0 };
    let encode = |value: f32| (255.0 * srgb_encode(value.min(1.0)) + 0.5) as u8;
    let mut picture = RgbImage::from_fn(width, height, |x, y| {
        Rgb((pixels[(y * width + x) as usize] * scale).to_array().map(encode))
    });
    // Small dots where there are many.
    let radius = (24.0 / (lights.len() as f32).sqrt()).clamp(1.2, 4.0);
    for light in lights {
        let d = light.direction;
        let at = Vec2::new(
            (0.5 + d.x.atan2(-d.z) / TAU) * width as f32,
            d.y.clamp(-1.0, 1.0).acos() / PI * height as f32,
        );
        dot(&mut picture, at, radius);
    }
    let mut png = Cursor::new(Vec::new());
    picture
        .write_to(&mut png, image::ImageFormat::Png)
        .map_err(|error| CliError::new(error.to_string()))?;
    Ok(png.into_inner())
}

/// A red disc with a dark rim, round the left and right edge.
fn dot(picture: &mut RgbImage, at: Vec2, radius: f32) {
    let rim = 1.0;
    let reach = (radius + rim).ceil() as i64;
    for down in -reach..=reach {
        for right in -reach..=reach {
            let [x, y] = [at.x.floor() as i64 + right, at.y.floor() as i64 + down];
            if !(0..i64::from(picture.height())).contains(&y) {
                continue;
            }
            let distance = (Vec2::new(x as f32, y as f32) + 0.5 - at).length();
            let cover = |radius: f32| (radius + 0.5 - distance).clamp(0.0, 1.0);
            let pixel =
                picture.get_pixel_mut(x.rem_euclid(i64::from(picture.width())) as u32, y as u32);
            for (colour, cover) in
                [([40, 0, 0], 0.7 * cover(radius + rim)), ([255, 50, 30], cover(radius))]
            {
                for (value, ink) in pixel.0.iter_mut().zip(colour) {
                    let mixed = f32::from(*value) * (1.0 - cover) + f32::from(ink as u8) * cover;
                    *value = mixed.round() as u8;
                }
            }
        }
    }
}
