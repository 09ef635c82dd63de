//! The sphere of directions under an equirectangular grid.
//!
//! Columns run with the azimuth, rows from the zenith down; the centre is -z, right is +x. Solid
//! angle is azimuth times the difference of the cosines of the polar angle.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec3};

/// Azimuth of a column coordinate, 0 to `width`: 0 in the centre of the map, growing to the right.
pub(crate) fn azimuth(x: f64, width: usize) -> f64 {
    (x / width as f64 - 0.5) * TAU
}

/// Cosines of the polar angle at the edges of the rows, from 1 down to -1.
pub(crate) fn row_edges(height: usize) -> Vec<f64> {
    (0..=height).map(|row| (PI * row as f64 / height as f64).cos()).collect()
}

/// The unit vector of an azimuth and a cosine of the polar angle.
pub(crate) fn direction(azimuth: f64, cos: f64) -> DVec3 {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    DVec3::new(sin * azimuth.sin(), cos, -sin * azimuth.cos())
}

/// Column and row coordinate of a direction of any length, 0 to `width` and to `height`.
pub(crate) fn place(direction: DVec3, width: usize, height: usize) -> DVec2 {
    let u = 0.5 + direction.x.atan2(-direction.z) / TAU;
    let v = direction.x.hypot(direction.z).atan2(direction.y) / PI;
    DVec2::new(u * width as f64, v * height as f64)
}

/// Column and row of the texel that a direction lies in.
pub(crate) fn texel(direction: DVec3, width: usize, height: usize) -> (usize, usize) {
    let at = place(direction, width, height);
    ((at.x as usize).min(width - 1), (at.y as usize).min(height - 1))
}

/// Integral of the unit vector over rows, by its components: (horizontal, vertical) for one radian of
/// azimuth, between two cosines of the polar angle with `top >= bottom`.
pub(crate) fn band(top: f64, bottom: f64) -> DVec2 {
    // The integrals of sqrt(1 - z^2) and of z.
    let horizontal = |z: f64| 0.5 * (z * (1.0 - z * z).max(0.0).sqrt() + z.clamp(-1.0, 1.0).asin());
    DVec2::new(horizontal(top) - horizontal(bottom), 0.5 * (top * top - bottom * bottom))
}

/// Integral of the horizontal unit vector (x, z) between two azimuths.
pub(crate) fn sector(from: f64, to: f64) -> DVec2 {
    DVec2::new(from.cos() - to.cos(), from.sin() - to.sin())
}

/// Relative luminance of linear Rec. 709.
pub(crate) fn luminance(rgb: Vec3) -> f64 {
    let rgb = rgb.as_dvec3();
    0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_is_minus_z_the_right_is_x_and_the_first_row_is_up() {
        for (at, texel_at) in [
            (DVec3::new(0.1, 0.1, -1.0), (4, 3)),
            (DVec3::new(1.0, 0.1, -0.1), (5, 3)),
            (DVec3::new(-1.0, -0.1, 0.1), (1, 4)),
            (DVec3::new(0.003, 1.0, -0.01), (4, 0)),
            (DVec3::new(0.01, -1.0, 0.001), (6, 7)),
        ] {
            assert_eq!(texel(at, 8, 8), texel_at, "{at}");
        }
        let there = direction(azimuth(5.3, 8), 0.3);
        assert!((place(there, 8, 4).x - 5.3).abs() < 1e-12);
        assert!((place(there, 8, 4).y / 4.0 * PI - 0.3_f64.acos()).abs() < 1e-12);
    }

    #[test]
    fn integrals_of_the_unit_vector() {
        // A patch, against many small pieces.
        let (a, b, top, bottom) = (0.3, 1.1, 0.9, -0.2);
        let pieces = 1000;
        let mut sum = DVec3::ZERO;
        for i in 0..pieces * pieces {
            let part = |at: usize| (at as f64 + 0.5) / f64::from(pieces as u32);
            let azimuth = a + (b - a) * part(i % pieces);
            sum += direction(azimuth, bottom + (top - bottom) * part(i / pieces));
        }
        sum *= (b - a) * (top - bottom) / f64::from((pieces * pieces) as u32);
        let (band, sector) = (band(top, bottom), sector(a, b));
        let exact = DVec3::new(band.x * sector.x, band.y * (b - a), band.x * sector.y);
        assert!((exact - sum).length() < 1e-6, "{exact} {sum}");
    }
}
