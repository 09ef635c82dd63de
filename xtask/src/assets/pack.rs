//! Rectangular charts on the texel grid of a lightmap square.

/// A chart's place: a rectangle of whole texels.
pub(super) struct Placed {
    /// Lower corner in metres of the chart and texels of the square a metre, along s and t.
    origin: [f64; 2],
    scale: [f64; 2],
    /// First texel and whether s runs along the rows.
    texel: [usize; 2],
    turned: bool,
    texels: f64,
}

impl Placed {
    pub(super) fn uv(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        let local = [(s - self.origin[0]) * self.scale[0], (t - self.origin[1]) * self.scale[1]];
        let local = if self.turned { [local[1], local[0]] } else { local };
        [0, 1].map(|k| (self.texel[k] as f64 + local[k]) / self.texels)
    }
}

/// Packs charts with bounds `[s0, t0, s1, t1]` in metres into a square: one texel of border round
/// each (so two between charts), at the highest common density that fits.
pub(super) fn pack(bounds: &[[f64; 4]], texels: usize) -> Vec<Placed> {
    let area: f64 = bounds.iter().map(|b| (b[2] - b[0]) * (b[3] - b[1])).sum();
    let mut density = texels as f64 / area.sqrt();
    loop {
        if let Some(placed) = try_pack(bounds, texels, density) {
            return placed;
        }
        density *= 0.98;
        assert!(density > 1e-3, "the charts do not fit: give the part more texels");
    }
}

fn try_pack(bounds: &[[f64; 4]], texels: usize, density: f64) -> Option<Vec<Placed>> {
    let size =
        |b: &[f64; 4]| [b[2] - b[0], b[3] - b[1]].map(|m| ((m * density).round() as usize).max(2));
    let mut order: Vec<usize> = (0..bounds.len()).collect();
    order.sort_by_key(|&i| {
        let [w, h] = size(&bounds[i]);
        (std::cmp::Reverse((w.max(h), w * h)), i)
    });
    let mut taken = vec![false; texels * texels];
    let mut placed: Vec<Option<Placed>> = bounds.iter().map(|_| None).collect();
    for i in order {
        let b = &bounds[i];
        let [w, h] = size(b);
        let (x, y, turned) = find(&taken, texels, w + 2, h + 2)?;
        let (columns, rows) = if turned { (h + 2, w + 2) } else { (w + 2, h + 2) };
        for row in y..y + rows {
            taken[row * texels + x..row * texels + x + columns].fill(true);
        }
        placed[i] = Some(Placed {
            origin: [b[0], b[1]],
            scale: [w as f64 / (b[2] - b[0]), h as f64 / (b[3] - b[1])],
            texel: [x + 1, y + 1],
            turned,
            texels: texels as f64,
        });
    }
    placed.into_iter().collect()
}

/// Whether squares of whole texels fit a page edge to edge.
#[cfg(test)]
pub(super) fn fits(squares: &[[f64; 4]], texels: usize) -> bool {
    // Each gets a border of one texel here, which stands for its own outermost texels.
    let inner: Vec<_> = squares.iter().map(|b| [0.0, 0.0, b[2] - 2.0, b[3] - 2.0]).collect();
    try_pack(&inner, texels, 1.0).is_some()
}

/// The free place nearest to the first row, in either orientation.
fn find(taken: &[bool], texels: usize, w: usize, h: usize) -> Option<(usize, usize, bool)> {
    let free = |x: usize, y: usize, w: usize, h: usize| {
        x + w <= texels
            && y + h <= texels
            && (y..y + h).all(|row| !taken[row * texels + x..row * texels + x + w].contains(&true))
    };
    let places = (0..texels).flat_map(|y| (0..texels).map(move |x| (x, y)));
    for (x, y) in places {
        if free(x, y, w, h) {
            return Some((x, y, false));
        }
        if free(x, y, h, w) {
            return Some((x, y, true));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_keep_their_distance() {
        let bounds = [[0.0, 0.0, 2.0, 1.0], [5.0, 0.0, 6.0, 3.0], [0.0, -1.0, 1.0, 0.0]];
        let placed = pack(&bounds, 32);
        let mut owner = vec![None; 32 * 32];
        for (i, (p, b)) in placed.iter().zip(bounds).enumerate() {
            let [low, high] =
                [p.uv([b[0], b[1]]), p.uv([b[2], b[3]])].map(|uv| uv.map(|v| v * 32.0));
            for v in low.iter().chain(&high) {
                assert!((v - v.round()).abs() < 1e-9, "whole texels: {v}");
            }
            // With the border round it no texel is claimed twice, and none lies outside.
            for y in low[1] as usize - 1..high[1] as usize + 1 {
                for x in low[0] as usize - 1..high[0] as usize + 1 {
                    assert_eq!(owner[y * 32 + x].replace(i), None);
                }
            }
        }
    }
}
