//! From luminance and chroma to red, green and blue.

use glam::Vec3;

/// What the three channels of a material mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ColourSpace {
    /// Luma and chroma of 8-bit video (ITU-R BT.601); the decoded value is gamma-encoded, 0 to 255
    /// for what a display can show, and may go beyond.
    #[default]
    YCbCr,
    /// Logarithmic luma, 410 u' and 410 v'; the decoded value is sRGB-encoded and may go beyond 1.
    LogLuv {
        /// The decoded colour is divided by this.
        factor: f32,
    },
}

impl ColourSpace {
    /// Red, green and blue of a luma and two chromas; each channel is clamped below at 0.
    ///
    /// With `linear`, [`ColourSpace::LogLuv`] is not encoded for a display; it changes nothing of
    /// [`ColourSpace::YCbCr`], whose tables hold encoded values.
    pub fn decode(self, luma: f32, chroma: [f32; 2], linear: bool) -> Vec3 {
        let [first, second] = chroma;
        match self {
            Self::YCbCr => Vec3::new(
                1.164_382_8 * luma + 1.596_027_3 * second - 222.921,
                1.164_382_8 * luma - 0.391_761_72 * first - 0.812_968_75 * second + 135.576,
                1.164_382_8 * luma + 2.017_234_4 * first - 276.836,
            )
            .max(Vec3::ZERO),
            Self::LogLuv { factor } => {
                let rgb = xyz_to_srgb(log_luv_to_xyz(luma, first, second)).max(Vec3::ZERO);
                let rgb = if linear { rgb } else { rgb.map(srgb_encode) };
                rgb / factor
            }
        }
    }
}

/// Luma and both chromas of [`ColourSpace::YCbCr`] that decode to red, green and blue of 0 to 255.
pub(crate) fn video_from_rgb([r, g, b]: [f64; 3]) -> [f64; 3] {
    // The constants of the decoder, which don't cancel exactly, solved for a luma. A row: the
    // decoded channel + offset = 1.1643828 luma + chroma part.
    let [r, g, b] = [r + 222.921, g - 135.576, b + 276.836];
    // g + k_b/2.017 (b) + k_r/1.596 (r) removes the chromas.
    let (blue, red) = (0.391_761_72 / 2.017_234_4, 0.812_968_75 / 1.596_027_3);
    let luma = (g + blue * b + red * r) / (1.164_382_8 * (1.0 + blue + red));
    [luma, (b - 1.164_382_8 * luma) / 2.017_234_4, (r - 1.164_382_8 * luma) / 1.596_027_3]
}

/// Luminance of a logarithmic luma: three pieces, linear, a power and an exponential.
fn luminance(luma: f32) -> f32 {
    if luma < 98.381 {
        0.056_968 * luma
    } else if luma < 1204.7 {
        (7.3014e-30_f64 * (f64::from(luma) + 884.17).powf(9.9872)) as f32
    } else {
        32.994 * (0.004_781_1 * luma).exp()
    }
}

fn log_luv_to_xyz(luma: f32, u: f32, v: f32) -> Vec3 {
    let y = luminance(luma);
    let v = v.max(1e-6);
    let x = 2.25 * (u / v) * y;
    Vec3::new(x, y, y * (3.0 * 410.0 / v - 5.0) - x / 3.0)
}

/// CIE XYZ to linear Rec. 709 (D65), IEC 61966-2-1.
fn xyz_to_srgb(xyz: Vec3) -> Vec3 {
    Vec3::new(
        xyz.dot(Vec3::new(3.240_97, -1.537_383_2, -0.498_610_76)),
        xyz.dot(Vec3::new(-0.969_243_65, 1.875_967_5, 0.041_555_06)),
        xyz.dot(Vec3::new(0.055_630_08, -0.203_976_96, 1.056_971_5)),
    )
}

/// The sRGB curve from linear to encoded, its power branch continued above 1.
pub fn srgb_encode(value: f32) -> f32 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

/// The sRGB curve from encoded to linear, its power branch continued above 1.
pub fn linear(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
