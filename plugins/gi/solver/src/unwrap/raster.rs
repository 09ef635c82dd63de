//! Which texel centres a triangle covers.

use glam::Vec2;

/// Calls `texel(x, y)` for the texels of a `size` x `size` square whose centres lie inside of a
/// triangle, at least `inset` texels from each edge. Rows are cut to spans, so the cost is that of
/// the rows and the texels found.
pub(super) fn covered(corners: [Vec2; 3], size: u32, inset: f32, mut texel: impl FnMut(u32, u32)) {
    let [a, mut b, mut c] = corners.map(|uv| (uv * size as f32).as_dvec2());
    let area = (b - a).perp_dot(c - a);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    if area < 0.0 {
        std::mem::swap(&mut b, &mut c);
    }
    let rows = [a, b, c].map(|p| p.y);
    let low = rows.into_iter().fold(f64::INFINITY, f64::min);
    let high = rows.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let last = f64::from(size) - 1.0;
    let first = (low - 0.5).ceil().max(0.0);
    let end = (high - 0.5).floor().min(last);
    if end < first {
        return;
    }
    for y in first as u32..=end as u32 {
        let cy = f64::from(y) + 0.5;
        let (mut from, mut to) = (0.5, last + 0.5);
        let mut empty = false;
        for [p, q] in [[a, b], [b, c], [c, a]] {
            // Inside is on the left: (q - p) x (center - p) >= inset |q - p|.
            let d = q - p;
            let value = d.x * (cy - p.y) + d.y * p.x - f64::from(inset) * d.length();
            if d.y > 0.0 {
                to = f64::min(to, value / d.y);
            } else if d.y < 0.0 {
                from = f64::max(from, value / d.y);
            } else if value < 0.0 {
                empty = true;
            }
        }
        if empty {
            continue;
        }
        let (start, end) = ((from - 0.5).ceil(), (to - 0.5).floor());
        if start <= end {
            for x in start as u32..=end as u32 {
                texel(x, y);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(corners: [[f32; 2]; 3], inset: f32) -> usize {
        let mut n = 0;
        covered(corners.map(Vec2::from), 16, inset, |x, y| {
            assert!(x < 16 && y < 16);
            n += 1;
        });
        n
    }

    #[test]
    fn half_squares_cover_half_and_share_no_texel() {
        let lower = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        let upper = [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        // The diagonal runs through 16 centres: with an inset they belong to neither.
        assert_eq!(count(lower, 0.01), 120);
        assert_eq!(count(upper, 0.01), 120);
        assert_eq!(count(lower, 0.0), 136);
        // Turned round it covers the same.
        assert_eq!(count([lower[0], lower[2], lower[1]], 0.01), 120);
    }

    #[test]
    fn outside_and_degenerate_triangles_cover_nothing() {
        assert_eq!(count([[2.0, 2.0], [3.0, 2.0], [3.0, 3.0]], 0.0), 0);
        assert_eq!(count([[-3.0, -3.0], [-2.0, -3.0], [-2.0, -2.0]], 0.0), 0);
        assert_eq!(count([[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]], 0.0), 0);
        assert_eq!(count([[0.0, 0.0], [f32::NAN, 0.5], [1.0, 1.0]], 0.0), 0);
        assert_eq!(count([[-9.0, -9.0], [9.0, -9.0], [0.5, 20.0]], 0.0), 256);
    }
}
