//! What stands round the objects: equirectangular pictures of light.
//!
//! `u = 0.5 + atan2(x, -z) / 2 pi`, `v = acos(y) / pi`: the centre is -z, right is +x, row 0 is up. An
//! object faces +z, where both edges of the picture meet. A value of 1 is a bright wall.

mod evening;
mod hdr;
mod interior;
mod landscape;
mod noise;
mod overcast;
mod sky;
mod studio;

use std::f64::consts::{PI, TAU};

use super::part::P;

const WIDTH: usize = 512;
const HEIGHT: usize = WIDTH / 2;
/// Angle that a pixel covers, in radians.
const PIXEL: f64 = PI / HEIGHT as f64;

/// Cosines of the angles where a sun's disc ends and where its edge begins. It is larger than the real
/// one, so that some pixels hold it.
const SUN_DISC: [f64; 2] = [0.9994, 0.9998];
/// Solid angle of that disc, its edge counted as half, over pi.
const SUN_DISC_SHARE: f64 = 2.0 - SUN_DISC[0] - SUN_DISC[1];

/// The environments: file name and file.
pub(super) fn all() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("studio.hdr", paint(studio::radiance)),
        ("sky.hdr", paint(sky::radiance)),
        ("evening.hdr", paint(evening::radiance)),
        ("overcast.hdr", paint(overcast::radiance)),
        ("interior.hdr", paint(interior::radiance)),
    ]
}

/// The picture of a function of direction; four samples a pixel.
fn paint(radiance: impl Fn(P) -> P) -> Vec<u8> {
    let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let mut sum = [0.0; 3];
            for (dx, dy) in [(0.25, 0.125), (0.75, 0.375), (0.25, 0.625), (0.75, 0.875)] {
                let turn = TAU * ((x as f64 + dx) / WIDTH as f64 - 0.5);
                let polar = PI * (y as f64 + dy) / HEIGHT as f64;
                let d = [polar.sin() * turn.sin(), polar.cos(), -polar.sin() * turn.cos()];
                let value = radiance(d);
                sum = [0, 1, 2].map(|k| sum[k] + value[k] * 0.25);
            }
            pixels.push(sum);
        }
    }
    hdr::write(WIDTH, &pixels)
}

fn mix(a: P, b: P, t: f64) -> P {
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t)
}

/// 0 below `from`, 1 above `to`, smooth between.
fn ramp(from: f64, to: f64, v: f64) -> f64 {
    let t = ((v - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// How much of a sun is seen at an angle of this cosine from its middle.
fn sun_disc(cosine: f64) -> f64 {
    ramp(SUN_DISC[0], SUN_DISC[1], cosine)
}

#[cfg(test)]
mod tests {
    #[test]
    fn files_are_small() {
        for (name, bytes) in super::all() {
            assert!(bytes.len() < 400_000, "{name}: {} bytes", bytes.len());
        }
    }
}
