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
