//! Images of the demo scene, painted from formulas.

use super::png::Indexed;

/// All images with their names, in the order that the materials expect.
///
/// `wall_rows` are the places along the wall's profile (0 = ceiling, 1 = floor) where it bends.
pub(super) fn all(wall_rows: &[f64]) -> Vec<(&'static str, Indexed)> {
    vec![
        ("planks", planks()),
        ("bright walls", walls(wall_rows, &BRIGHT)),
        ("tiles", tiles()),
        ("dark walls", walls(wall_rows, &DARK)),
        ("oak", wood([0.76, 0.58, 0.38], 1)),
        ("walnut", wood([0.52, 0.36, 0.25], 2)),
        ("colours", palette()),
        ("pictures", pictures()),
        ("rug", rug()),
    ]
}

/// Those of the study, likewise.
pub(super) fn study() -> Vec<(&'static str, Indexed)> {
    vec![
        ("planks", planks()),
        ("oak", wood([0.76, 0.58, 0.38], 1)),
        ("colours", palette()),
        ("pictures", pictures()),
        ("rug", rug()),
    ]
}

/// Colours that objects have, sRGB.
pub(super) const PALETTE: [[f64; 3]; 16] = [
    [0.85, 0.20, 0.14], // 0 red
    [0.93, 0.68, 0.15], // 1 yellow
    [0.12, 0.46, 0.72], // 2 blue
    [0.20, 0.60, 0.34], // 3 green
    [0.92, 0.90, 0.85], // 4 white
    [0.88, 0.45, 0.18], // 5 orange
    [0.10, 0.55, 0.55], // 6 teal
    [0.72, 0.40, 0.28], // 7 terracotta
    [0.33, 0.50, 0.22], // 8 leaf
    [0.30, 0.32, 0.62], // 9 indigo
    [0.80, 0.75, 0.62], // 10 linen
    [0.55, 0.16, 0.22], // 11 wine
    [0.55, 0.72, 0.85], // 12 sky
    [0.25, 0.25, 0.28], // 13 slate
    [0.86, 0.62, 0.60], // 14 rose
    [0.62, 0.72, 0.45], // 15 moss
];

/// Upper wall and wainscot of the four walls: north, east, south, west.
type Scheme = [[[f64; 3]; 2]; 4];

const CREAM: [f64; 3] = [0.90, 0.86, 0.76];
const GREIGE: [f64; 3] = [0.86, 0.85, 0.83];

const BRIGHT: Scheme = [
    [CREAM, [0.83, 0.76, 0.62]],
    [CREAM, [0.83, 0.76, 0.62]],
    [CREAM, [0.83, 0.76, 0.62]],
    [[0.84, 0.24, 0.17], [0.72, 0.17, 0.13]],
];

const DARK: Scheme = [
    [[0.36, 0.58, 0.80], [0.26, 0.45, 0.68]],
    [GREIGE, [0.74, 0.74, 0.74]],
    [[0.46, 0.70, 0.48], [0.34, 0.58, 0.38]],
    [GREIGE, [0.74, 0.74, 0.74]],
];

fn walls(rows: &[f64], scheme: &Scheme) -> Indexed {
    const HEIGHT: usize = 256;
    // Bends 5 (below the crown), 7 (above the dado rail), 10 (below it), 11 (above the skirting).
    let [crown, rail, wainscot, skirting] = [5, 7, 10, 11].map(|i| rows[i]);
    Indexed::paint(32, HEIGHT, |x, y| {
        let [upper, lower] = scheme[x / 8];
        let white = [0.93, 0.91, 0.87];
        let t = (y as f64 + 0.5) / HEIGHT as f64;
        let mottled = |c: [f64; 3]| c.map(|v| v + 0.016 * (noise(x as i64, y as i64 / 4, 8) - 0.5));
        if t < crown || (rail..wainscot).contains(&t) || t > skirting {
            white
        } else if t < rail {
            mottled(upper)
        } else {
            mottled(lower)
        }
    })
}

/// Eight boards along x, each its own tone, with joints.
fn planks() -> Indexed {
    const N: usize = 128;
    Indexed::paint(N, N, |x, y| {
        let board = y / 16;
        let joint = (board * 53 + 11) % N;
        // A board's two halves differ; grain runs along it and repeats with the image.
        let half = usize::from((x + N - joint) % N >= N / 2 + 9 * (board % 3));
        let tone = noise(board as i64, half as i64, 64);
        let grain = wave_noise(x as f64, y as f64 * 5.0 + tone * 90.0, N);
        let seam = y % 16 == 0 || x == joint || x == (joint + N / 2 + 9 * (board % 3)) % N;
        let light = (0.86 + 0.16 * tone + 0.09 * (grain - 0.5)) * if seam { 0.62 } else { 1.0 };
        [0.74, 0.55, 0.36].map(|c| c * light)
    })
}

/// Four by four stone tiles with joints.
fn tiles() -> Indexed {
    const N: usize = 128;
    Indexed::paint(N, N, |x, y| {
        let (tx, ty) = (x / 32, y / 32);
        let tone = noise(tx as i64 + 7, ty as i64 + 3, 4);
        let joint = x % 32 == 0 || y % 32 == 0;
        let cloud = wave_noise(x as f64 * 1.5, y as f64 * 1.5, N);
        let light = if joint { 0.52 } else { 0.70 + 0.07 * tone + 0.05 * (cloud - 0.5) };
        let warm = if (tx + ty) % 2 == 0 { 1.0 } else { 0.93 };
        [light * warm, light * warm * 0.985, light * warm * 0.96]
    })
}

fn wood(color: [f64; 3], seed: i64) -> Indexed {
    const N: usize = 64;
    Indexed::paint(N, N, |x, y| {
        let bend = 5.0 * noise(x as i64 / 16 + seed * 31, 5, 64);
        let grain = wave_noise(x as f64 * 0.5, (y as f64 + bend) * 4.0 + seed as f64 * 40.0, N * 4);
        let line = noise(seed, y as i64, N as i64);
        color.map(|c| c * (0.88 + 0.16 * grain + 0.08 * (line - 0.5)))
    })
}

fn palette() -> Indexed {
    Indexed::paint(16, 1, |x, _| PALETTE[x])
}

/// Four pictures in a row of 64 x 64 pixels; the last column of each is the frame's colour.
fn pictures() -> Indexed {
    Indexed::paint(256, 64, |x, y| {
        let (picture, x) = (x / 64, x % 64);
        if x >= 60 {
            return [0.30, 0.20, 0.13];
        }
        let (u, v) = ((x as f64 + 0.5) / 60.0, (y as f64 + 0.5) / 64.0);
        match picture {
            0 => hills(u, v),
            1 => blocks(u, v),
            2 => moon(u, v),
            _ => stripes(u, v),
        }
    })
}

/// A sunset behind three ridges.
fn hills(u: f64, v: f64) -> [f64; 3] {
    let ridge = |height: f64, waves: f64, shift: f64| {
        height + 0.07 * (waves * u + shift).sin() + 0.03 * (2.7 * waves * u + shift).sin()
    };
    let layers = [
        (ridge(0.80, 5.0, 0.4), [0.16, 0.22, 0.26]),
        (ridge(0.64, 6.0, 2.0), [0.30, 0.36, 0.40]),
        (ridge(0.50, 4.0, 4.0), [0.62, 0.48, 0.46]),
    ];
    for (height, color) in layers {
        if v > height {
            return color;
        }
    }
    if (u - 0.66).hypot(v - 0.34) < 0.11 {
        return [0.99, 0.90, 0.62];
    }
    mix([0.93, 0.58, 0.30], [0.98, 0.82, 0.55], (v / 0.5).min(1.0))
}

/// Rectangles of plain colours between dark lines.
fn blocks(u: f64, v: f64) -> [f64; 3] {
    let line = |a: f64, at: f64| (a - at).abs() < 0.02;
    if line(u, 0.3) || line(v, 0.62) || (u < 0.3 && line(v, 0.3)) || (v > 0.62 && line(u, 0.75)) {
        return [0.12, 0.12, 0.13];
    }
    match (u < 0.3, v < 0.62) {
        (true, true) if v < 0.3 => [0.93, 0.90, 0.82],
        (true, true) => [0.15, 0.32, 0.62],
        (false, true) => [0.84, 0.22, 0.16],
        (true, false) => [0.93, 0.90, 0.82],
        (false, false) if u < 0.75 => [0.93, 0.90, 0.82],
        (false, false) => [0.95, 0.78, 0.22],
    }
}

/// A moon over water.
fn moon(u: f64, v: f64) -> [f64; 3] {
    let disc = (u - 0.5).hypot(v - 0.3);
    if disc < 0.14 {
        return [0.95, 0.94, 0.86];
    }
    if v > 0.62 {
        let glint = (u - 0.5).abs() < 0.12 + 0.05 * (v * 60.0).sin();
        return if glint {
            [0.62, 0.74, 0.80]
        } else {
            mix([0.14, 0.30, 0.42], [0.08, 0.18, 0.30], v)
        };
    }
    mix([0.32, 0.48, 0.62], [0.12, 0.22, 0.40], (disc * 1.6).min(1.0))
}

/// Woven bands.
fn stripes(u: f64, v: f64) -> [f64; 3] {
    let colors = [[0.90, 0.84, 0.70], [0.16, 0.50, 0.48], [0.92, 0.62, 0.24], [0.58, 0.20, 0.24]];
    let zigzag = ((u * 5.0).fract() - 0.5).abs() * 0.16;
    colors[((v + zigzag) * 7.0) as usize % 4]
}

/// A border, diamonds and a medallion.
fn rug() -> Indexed {
    const W: usize = 96;
    const H: usize = 80;
    Indexed::paint(W, H, |x, y| {
        let (u, v) = (x as f64 + 0.5, y as f64 + 0.5);
        let edge = u.min(v).min(W as f64 - u).min(H as f64 - v);
        let (cream, deep, accent) = ([0.88, 0.82, 0.68], [0.13, 0.34, 0.40], [0.78, 0.32, 0.22]);
        let weave = 1.0 + 0.05 * (noise(x as i64, y as i64, 128) - 0.5);
        let (cx, cy) = ((u - W as f64 / 2.0).abs(), (v - H as f64 / 2.0).abs());
        let color = if edge < 3.0 {
            deep
        } else if edge < 5.0 {
            cream
        } else if edge < 12.0 {
            let bead = ((u + v) as i64 / 4) % 2 == 0;
            if bead { accent } else { deep }
        } else if edge < 14.0 {
            cream
        } else {
            match cx / 30.0 + cy / 24.0 {
                d if d < 0.22 => accent,
                d if d < 0.34 => cream,
                d if d < 0.78 => deep,
                d if d < 0.88 => cream,
                _ if ((cx as i64 / 5) + (cy as i64 / 5)) % 3 == 0 => accent,
                _ => deep.map(|c| c * 1.18),
            }
        };
        color.map(|c| c * weave)
    })
}

fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t)
}

/// A random number 0..1 of a lattice point that repeats every `period` in x.
fn noise(x: i64, y: i64, period: i64) -> f64 {
    let mut h = (x.rem_euclid(period) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    h = (h ^ h >> 31).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ h >> 29).wrapping_mul(0x94d0_49bb_1331_11eb);
    (h >> 40) as f64 / (1_u64 << 24) as f64
}

/// Smooth noise with cells of 8 pixels, repeating after `period` pixels in x and y.
fn wave_noise(x: f64, y: f64, period: usize) -> f64 {
    let cells = (period / 8) as i64;
    let (x, y) = (x / 8.0, y / 8.0);
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let at = |dx: i64, dy: i64| {
        noise(x.floor() as i64 + dx, (y.floor() as i64 + dy).rem_euclid(cells * 8), cells)
    };
    let top = at(0, 0) + (at(1, 0) - at(0, 0)) * ease(fx);
    let bottom = at(0, 1) + (at(1, 1) - at(0, 1)) * ease(fx);
    top + (bottom - top) * ease(fy)
}
