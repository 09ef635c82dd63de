//! Gradient noise and sums of its octaves.
//!
//! K. Perlin, *Improving noise*, SIGGRAPH 2002; octaves that a pixel cannot show are left out as in
//! A. Norton et al., *Clamping*, SIGGRAPH 1982.

/// Octaves of a sum; the last one is 1/64 as wide as the first.
const OCTAVES: u32 = 7;

/// A sum of octaves, each half as strong and half as wide as the one before; mostly -0.6..0.6, mean 0.
///
/// The first octave is about one unit wide. `footprint` is how much of the plane a pixel covers, in
/// the same unit.
pub(super) fn octaves([mut x, mut y]: [f64; 2], footprint: f64) -> f64 {
    let (mut sum, mut strength, mut width) = (0.0, 0.8, 1.0);
    for _ in 0..OCTAVES {
        // Gone where a pixel covers the octave's width, whole where it covers a third.
        let seen = ((width / footprint.max(1e-9) - 1.0) / 2.0).clamp(0.0, 1.0);
        if seen <= 0.0 {
            break;
        }
        sum += strength * seen * gradient(x, y);
        strength *= 0.5;
        width *= 0.5;
        // Turned, so that the lattices of the octaves do not show.
        (x, y) = (1.6 * x + 1.2 * y + 17.3, 1.6 * y - 1.2 * x + 9.1);
    }
    sum
}

/// Noise of one width, -1..1, 0 at lattice points.
fn gradient(x: f64, y: f64) -> f64 {
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let at = |dx: f64, dy: f64| {
        let hash = hash((x.floor() + dx) as i64, (y.floor() + dy) as i64);
        let (sin, cos) = (hash * std::f64::consts::TAU).sin_cos();
        1.4 * (cos * (fx - dx) + sin * (fy - dy))
    };
    let smooth = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let row = |dy| at(0.0, dy) + (at(1.0, dy) - at(0.0, dy)) * smooth(fx);
    row(0.0) + (row(1.0) - row(0.0)) * smooth(fy)
}

/// 0..1.
fn hash(x: i64, y: i64) -> f64 {
    let mut h = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    h = (h ^ h >> 31).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ h >> 29).wrapping_mul(0x94d0_49bb_1331_11eb);
    (h >> 40) as f64 / (1_u64 << 24) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_nothing_and_a_wide_pixel_sees_the_mean() {
        let (mut sum, mut squares, n) = (0.0, 0.0, 200);
        for i in 0..n * n {
            let p = [f64::from(i % n) * 0.37, f64::from(i / n) * 0.37];
            let v = octaves(p, 0.0);
            (sum, squares) = (sum + v, squares + v * v);
            assert!(v.abs() < 1.5, "{v}");
            assert_eq!(octaves(p, 1.0), 0.0);
        }
        let (mean, square) = (sum / f64::from(n * n), squares / f64::from(n * n));
        assert!(mean.abs() < 0.02 && square.sqrt() > 0.15, "mean {mean}, deviation {square}");
    }
}
