//! Rectangular charts on the texel grid of a part's lightmap rectangle.

/// The rectangle's edges plus [`PADDING`] on both sides are multiples of this, as the solver's atlas
/// makes them.
const ALIGN: usize = 4;
const PADDING: usize = 1;
/// Widest rectangle: a row of texels is held in the bits of a `u128`.
const WIDEST: usize = 126;

/// Where the charts of a part lie.
pub(super) struct Layout {
    /// Columns and rows.
    pub(super) size: [usize; 2],
    charts: Vec<Placed>,
}

/// A chart's place: a rectangle of whole texels.
struct Placed {
    /// Lower corner in metres of the chart and texels a metre, along s and t.
    origin: [f64; 2],
    scale: [f64; 2],
    /// First texel, and whether s runs along the rows.
    texel: [usize; 2],
    turned: bool,
}

impl Layout {
    /// Texel coordinates of a point of a chart.
    pub(super) fn texel(&self, chart: usize, [s, t]: [f64; 2]) -> [f64; 2] {
        let placed = &self.charts[chart];
        let local =
            [(s - placed.origin[0]) * placed.scale[0], (t - placed.origin[1]) * placed.scale[1]];
        let local = if placed.turned { [local[1], local[0]] } else { local };
        [0, 1].map(|k| placed.texel[k] as f64 + local[k])
    }

    /// Coordinates in the unit square.
    pub(super) fn uv(&self, chart: usize, point: [f64; 2]) -> [f64; 2] {
        let texel = self.texel(chart, point);
        [0, 1].map(|k| texel[k] / self.size[k] as f64)
    }
}

/// Packs charts with bounds `[s0, t0, s1, t1]` in metres into the smallest rectangle that is found:
/// `density` texels a metre or a little more, each chart whole texels and at least two of them, one
/// texel of border round each (so two between charts).
pub(super) fn pack(bounds: &[[f64; 4]], density: f64) -> Layout {
    let sizes: Vec<[usize; 2]> = bounds
        .iter()
        .map(|b| [b[2] - b[0], b[3] - b[1]].map(|m| ((m * density - 1e-6).ceil() as usize).max(2)))
        .collect();
    let outer: Vec<_> = sizes.iter().map(|s| s.map(|v| v + 2)).collect();
    let area: usize = outer.iter().map(|[w, h]| w * h).sum();
    let widest = outer.iter().map(|[w, h]| *w.min(h)).max().unwrap_or(0);
    let side = (area as f64).sqrt();
    let (_, size, places) = (widest.max((side * 0.7) as usize)
        ..=((side * 1.7) as usize).min(WIDEST))
        .filter(|width| (width + 2 * PADDING).is_multiple_of(ALIGN))
        .filter_map(|width| {
            let places = arrange(&outer, width)?;
            let used = places.iter().zip(&outer).map(|(p, o)| p.1 + if p.2 { o[0] } else { o[1] });
            let rows = used.max().unwrap_or(0) + 2 * PADDING;
            let height = rows.next_multiple_of(ALIGN) - 2 * PADDING;
            let cost = (width + 2 * PADDING) * (height + 2 * PADDING);
            Some(((cost, width.abs_diff(height)), [width, height], places))
        })
        .min_by_key(|(cost, ..)| *cost)
        .expect("the charts fit a rectangle");
    let charts = bounds.iter().zip(&sizes).zip(places);
    let charts = charts
        .map(|((b, [w, h]), (x, y, turned))| Placed {
            origin: [b[0], b[1]],
            scale: [*w as f64 / (b[2] - b[0]), *h as f64 / (b[3] - b[1])],
            texel: [x + 1, y + 1],
            turned,
        })
        .collect();
    Layout { size, charts }
}

/// Places rectangles, large ones first, each at the first row and column that are free, in either
/// orientation. `None` if that takes more than 128 rows.
pub(super) fn arrange(sizes: &[[usize; 2]], width: usize) -> Option<Vec<(usize, usize, bool)>> {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&i| {
        let [w, h] = sizes[i];
        (std::cmp::Reverse((w.max(h), w * h)), i)
    });
    // One bit a texel; columns beyond the width are taken.
    let outside = if width < 128 { !0 << width } else { 0 };
    let mut rows: [u128; 128] = [outside; 128];
    let mut places = vec![(0, 0, false); sizes.len()];
    for i in order {
        let [w, h] = sizes[i];
        let (x, y, turned) = (0..rows.len()).find_map(|y| {
            [(w, h, false), (h, w, true)].into_iter().find_map(|(w, h, turned)| {
                let free = !rows.get(y..y + h)?.iter().fold(0, |all, row| all | row);
                let starts: u128 = (1..w).fold(free, |starts, k| starts & (free >> k));
                (starts != 0).then(|| (starts.trailing_zeros() as usize, y, turned))
            })
        })?;
        let (columns, lines) = if turned { (h, w) } else { (w, h) };
        for row in &mut rows[y..y + lines] {
            *row |= (!0 >> (128 - columns)) << x;
        }
        places[i] = (x, y, turned);
    }
    Some(places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_keep_their_distance() {
        let bounds = [[0.0, 0.0, 2.0, 1.0], [5.0, 0.0, 6.0, 3.0], [0.0, -1.0, 0.01, 0.0]];
        let layout = pack(&bounds, 5.0);
        let [width, height] = layout.size;
        let mut owner = vec![None; width * height];
        for (i, b) in bounds.iter().enumerate() {
            let [low, high] = [[b[0], b[1]], [b[2], b[3]]].map(|p| layout.texel(i, p));
            for v in low.iter().chain(&high) {
                assert!((v - v.round()).abs() < 1e-9, "whole texels: {v}");
            }
            // With the border round it no texel is claimed twice, and none lies outside.
            for y in low[1] as usize - 1..high[1] as usize + 1 {
                for x in low[0] as usize - 1..high[0] as usize + 1 {
                    assert_eq!(owner[y * width + x].replace(i), None);
                }
            }
        }
        assert_eq!(((width + 2) % 4, (height + 2) % 4), (0, 0));
    }
}
