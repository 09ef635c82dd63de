//! Texels of three times nine bits that share an exponent of five: four bytes, 0 to 65408.
//!
//! OpenGL extension EXT_texture_shared_exponent, section 3.8.x; Khronos Data Format Specification,
//! section 10.4.

use glam::Vec3;

/// The largest value of a channel: 511 / 512 · 2^16.
pub const MAX: f32 = 65408.0;

/// The smallest value of a channel that isn't 0.
pub const MIN_POSITIVE: f32 = 1.0 / 16_777_216.0;

/// The nearest texel. Channels that are negative or not a number become 0, those above [`MAX`] become
/// that.
///
/// The error of a channel is at most 1/1024 of the largest channel's next power of two, and so at most
/// 1/512 of the largest channel.
#[must_use]
pub fn encode(colour: Vec3) -> u32 {
    // f32::max turns NaN, which clamp keeps, into the bound.
    let channels = colour.to_array().map(|v| v.clamp(0.0, MAX).max(0.0));
    let largest = channels[0].max(channels[1]).max(channels[2]);
    // floor(log2) is the exponent of the number itself; subnormal ones have -127, which is small enough.
    let log2 = (largest.to_bits() >> 23) as i32 - 127;
    let mut exponent = log2.max(-16) + 16;
    if (largest / unit(exponent)).round() >= 512.0 {
        exponent += 1;
    }
    // Division by a power of two is exact, and `round` takes halves up, as the specification does.
    let [r, g, b] = channels.map(|v| (v / unit(exponent)).round() as u32);
    (exponent as u32) << 27 | b << 18 | g << 9 | r
}

/// The colour of a texel; exact.
#[must_use]
pub fn decode(texel: u32) -> Vec3 {
    let unit = unit((texel >> 27) as i32);
    Vec3::from_array([0, 9, 18].map(|shift| (texel >> shift & 0x1ff) as f32 * unit))
}

/// What one step of a channel is worth: 2^(exponent - 15 - 9), for exponents 0 to 31.
fn unit(exponent: i32) -> f32 {
    f32::from_bits(((exponent - 24 + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn there_and_back(colour: Vec3) -> Vec3 {
        decode(encode(colour))
    }

    /// What is decoded is encoded as an equal colour: all mantissas of a channel, all exponents.
    #[test]
    fn every_value_survives() {
        for exponent in 0..32 {
            for mantissa in 0..512 {
                let texel =
                    exponent << 27 | (511 - mantissa) << 18 | (mantissa / 3) << 9 | mantissa;
                let colour = decode(texel);
                assert_eq!(there_and_back(colour), colour, "{texel:#x}");
                // With a mantissa of 256 or more the exponent is the smallest that holds it.
                if mantissa >= 256 {
                    assert_eq!(encode(colour), texel, "{texel:#x}");
                }
            }
        }
    }

    #[test]
    fn known_texels() {
        assert_eq!(encode(Vec3::ZERO), 0);
        assert_eq!(encode(Vec3::new(1.0, 0.5, 1.0 / 256.0)), 16 << 27 | 1 << 18 | 128 << 9 | 256);
        assert_eq!(encode(Vec3::splat(MAX)), u32::MAX);
        assert_eq!(encode(Vec3::new(MIN_POSITIVE, 0.0, 0.0)), 1);
    }

    #[test]
    fn what_has_no_texel_is_clamped() {
        let (nan, infinity) = (f32::NAN, f32::INFINITY);
        assert_eq!(there_and_back(Vec3::new(nan, 1.0, -1.0)), Vec3::new(0.0, 1.0, 0.0));
        assert_eq!(there_and_back(Vec3::new(infinity, -infinity, 0.0)), Vec3::new(MAX, 0.0, 0.0));
        assert_eq!(there_and_back(Vec3::splat(1e9)), Vec3::splat(MAX));
        // Half a step and more rounds up, also where it needs the next exponent.
        assert_eq!(there_and_back(Vec3::X * (MIN_POSITIVE * 0.5)), Vec3::X * MIN_POSITIVE);
        assert_eq!(there_and_back(Vec3::X * (MIN_POSITIVE * 0.499)), Vec3::ZERO);
        assert_eq!(there_and_back(Vec3::X * f32::from_bits(1)), Vec3::ZERO);
        assert_eq!(there_and_back(Vec3::X * 511.5), Vec3::X * 512.0);
        assert_eq!(there_and_back(Vec3::X * 511.499), Vec3::X * 511.0);
    }

    /// Within half a step of the largest channel's exponent, over all magnitudes.
    #[test]
    fn the_nearest_is_taken() {
        for step in 0..4000 {
            let v = ((step as f32) * 0.01 - 24.0).exp2();
            let colour = Vec3::new(v, v * 0.37, v * 0.011).min(Vec3::splat(MAX));
            let error = (there_and_back(colour) - colour).abs().max_element();
            assert!(error <= (v / 512.0).max(MIN_POSITIVE * 0.5), "{colour}: {error}");
        }
    }
}
