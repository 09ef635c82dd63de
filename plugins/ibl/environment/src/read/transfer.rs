//! The transfer function of pictures for screens.

/// Linear value of an sRGB value of 0 to 1 (IEC 61966-2-1).
pub(super) fn srgb_decode(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
