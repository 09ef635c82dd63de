//! What stands in the rooms.

use super::{
    doorway::Look,
    part::{P, Part, Uv},
    shapes::{Ends, beam, block, cap, lathe, shelf_board},
};

/// Beams, a table and a bench of oak.
pub(super) fn bright_woodwork() -> Part {
    let mut part = Part::new("bright_woodwork", Look::Oak as usize);
    for x in [-4.35, -2.6, -0.85] {
        let (low, high) = ([x - 0.09, 2.78, -2.52], [x + 0.09, 3.02, 2.52]);
        beam(&mut part, low, high, 0.015, Uv::TileAcross(1.0));
    }
    let wood = Uv::Tile(1.0);
    table(&mut part, [-3.75, -1.75], [-1.75, -0.85], 0.74, 0.045, 0.07, wood);
    table(&mut part, [-3.55, -1.95], [-0.60, -0.28], 0.45, 0.045, 0.06, wood);
    part
}

/// A top on four legs; x and z are ranges.
pub(super) fn table(
    part: &mut Part,
    x: [f64; 2],
    z: [f64; 2],
    height: f64,
    thick: f64,
    leg: f64,
    uv: Uv,
) {
    let under = height - thick;
    block(part, [x[0], under, z[0]], [x[1], height, z[1]], 0.012, Ends::Both, uv);
    for lx in [x[0] + 0.05, x[1] - 0.05 - leg] {
        for lz in [z[0] + 0.05, z[1] - 0.05 - leg] {
            let (low, high) = ([lx, -0.01, lz], [lx + leg, under + 0.01, lz + leg]);
            block(part, low, high, 0.01, Ends::None, Uv::TileAcross(1.0));
        }
    }
}

/// Coloured things in the bright room.
pub(super) fn bright_objects() -> Part {
    let mut part = Part::new("bright_objects", Look::Palette as usize);
    let part_ref = &mut part;
    let table = 0.735;
    bowl(part_ref, [-2.75, table, -1.3], 5);
    vase(part_ref, [-2.1, table, -1.5], 0.8, 2);
    cube(part_ref, [-3.55, table, -1.45], [0.26, 0.2, 0.2], 0);
    cube(part_ref, [-3.5, table + 0.195, -1.42], [0.16, 0.09, 0.14], 1);
    // A chest with a box on it, beside the red wall.
    cube(part_ref, [-4.85, -0.01, 1.2], [0.62, 0.5, 0.95], 6);
    cube(part_ref, [-4.7, 0.485, 1.5], [0.36, 0.28, 0.36], 1);
    // A small tree in a pot beside the doorway.
    let pot = [-0.55, -0.005, -1.95];
    let profile =
        [[0.15, 0.36], [0.19, 0.40], [0.21, 0.40], [0.215, 0.35], [0.19, 0.34], [0.15, 0.0]];
    lathe(part_ref, pot, &profile, 16, Uv::Swatch(7));
    lathe(part_ref, pot, &[[0.022, 1.0], [0.03, 0.33]], 8, Uv::Swatch(13));
    ball(part_ref, [pot[0], 1.16, pot[2]], 0.31, 8);
    disc(part_ref, [pot[0], 0.355, pot[2]], 0.17, 13);
    part
}

/// A shelf and a bench of walnut.
pub(super) fn dark_woodwork() -> Part {
    let mut part = Part::new("dark_woodwork", Look::Walnut as usize);
    let wood = Uv::Tile(1.0);
    let (x, back, front) = (SHELF_X, -2.44, SHELF_FRONT);
    for x in [x[0] - 0.04, x[1]] {
        let (low, high) = ([x, -0.01, -2.495], [x + 0.04, 2.0, front + 0.01]);
        block(&mut part, low, high, 0.008, Ends::Top, Uv::TileAcross(1.0));
    }
    for top in SHELF_TOPS {
        let (low, high) = ([x[0] - 0.005, top - 0.03, back - 0.01], [x[1] + 0.005, top, front]);
        shelf_board(&mut part, low, high, 0.006, wood);
    }
    part.chart();
    let corner = |x: f64, y: f64| ([x, y, back], [x, y]);
    let (x0, x1) = (x[0] - 0.005, x[1] + 0.005);
    part.face(&[corner(x0, -0.01), corner(x1, -0.01), corner(x1, 1.98), corner(x0, 1.98)], wood);
    table(&mut part, [1.3, 2.9], [1.98, 2.4], 0.44, 0.05, 0.07, wood);
    part
}

const SHELF_X: [f64; 2] = [1.35, 3.05];
const SHELF_FRONT: f64 = -2.14;
const SHELF_TOPS: [f64; 5] = [0.11, 0.56, 1.01, 1.46, 1.97];

/// Coloured things in the dark room.
pub(super) fn dark_objects() -> Part {
    let mut part = Part::new("dark_objects", Look::Palette as usize);
    let part_ref = &mut part;
    // Books and boxes: board, left edge, width, height, colour.
    let things = [
        (0, 1.45, 0.50, 0.30, 6),
        (0, 2.10, 0.34, 0.24, 1),
        (0, 2.55, 0.40, 0.33, 9),
        (1, 1.42, 0.16, 0.30, 0),
        (1, 1.59, 0.12, 0.26, 4),
        (1, 1.72, 0.18, 0.32, 3),
        (1, 2.45, 0.48, 0.22, 10),
        (2, 1.50, 0.36, 0.28, 5),
        (2, 2.30, 0.14, 0.31, 11),
        (2, 2.45, 0.18, 0.27, 12),
        (2, 2.64, 0.14, 0.33, 1),
        (2, 2.79, 0.16, 0.29, 3),
        (3, 1.45, 0.20, 0.34, 2),
        (3, 1.66, 0.16, 0.30, 14),
        (3, 2.50, 0.40, 0.26, 0),
    ];
    for (board, x, width, height, color) in things {
        let low = [x, SHELF_TOPS[board] - 0.005, -2.40];
        cube(part_ref, low, [width, height, 0.20], color);
    }
    vase(part_ref, [2.15, SHELF_TOPS[1] - 0.005, -2.29], 0.6, 5);
    bowl(part_ref, [2.05, SHELF_TOPS[3] - 0.005, -2.29], 6);
    // Cushions on the bench, a vase on the pedestal.
    for (x, color) in [(1.34, 14), (2.13, 15)] {
        let low = [x, 0.435, 2.0];
        block(part_ref, low, [x + 0.73, 0.52, 2.38], 0.03, Ends::Top, Uv::Swatch(color));
    }
    vase(part_ref, [PEDESTAL[0], 1.015, PEDESTAL[1]], 1.5, 2);
    part
}

const PEDESTAL: [f64; 2] = [4.45, 0.6];

/// Two columns and a pedestal between them.
pub(super) fn stone() -> Part {
    let mut part = Part::new("stone", Look::Stone as usize);
    let stone = Uv::Tile(1.0);
    for z in [-1.7, 1.9] {
        let base = [4.5, 0.0, z];
        let profile = [
            [0.28, 3.02],
            [0.28, 2.84],
            [0.24, 2.80],
            [0.17, 2.74],
            [0.17, 2.68],
            [0.19, 2.66],
            [0.19, 2.62],
            [0.155, 2.60],
            [0.175, 1.30],
            [0.185, 0.30],
            [0.225, 0.26],
            [0.235, 0.22],
            [0.225, 0.18],
            [0.26, 0.15],
            [0.265, 0.09],
        ];
        lathe(&mut part, base, &profile, 24, stone);
        plate(&mut part, base, 0.31, [-0.01, 0.10], stone);
    }
    let base = [PEDESTAL[0], 0.0, PEDESTAL[1]];
    plate(&mut part, base, 0.30, [-0.01, 0.12], stone);
    let low = [base[0] - 0.21, 0.11, base[2] - 0.21];
    block(&mut part, low, [base[0] + 0.21, 0.95, base[2] + 0.21], 0.02, Ends::None, stone);
    let low = [base[0] - 0.27, 0.94, base[2] - 0.27];
    block(&mut part, low, [base[0] + 0.27, 1.02, base[2] + 0.27], 0.02, Ends::Both, stone);
    part
}

/// A square plate whose bottom is hidden.
fn plate(part: &mut Part, base: P, half: f64, y: [f64; 2], uv: Uv) {
    let low = [base[0] - half, y[0], base[2] - half];
    block(part, low, [base[0] + half, y[1], base[2] + half], 0.015, Ends::Top, uv);
}

/// Pictures on the north wall of the bright room and the south wall of the dark one.
pub(super) fn pictures() -> Part {
    let mut part = Part::new("pictures", Look::Pictures as usize);
    picture(&mut part, [-3.1, 1.75, -2.5], [1.1, 0.85], 1.0, 0);
    picture(&mut part, [-1.55, 1.75, -2.5], [0.7, 0.85], 1.0, 1);
    picture(&mut part, [1.6, 1.65, 2.5], [0.6, 0.75], -1.0, 2);
    picture(&mut part, [2.5, 1.65, 2.5], [0.6, 0.75], -1.0, 3);
    part
}

/// A picture with a frame whose sides slope, so that the whole is one flat chart. `facing` is the
/// sign of the normal's z.
pub(super) fn picture(part: &mut Part, center: P, size: [f64; 2], facing: f64, image: usize) {
    part.chart();
    let ring = |inset: f64, out: f64| {
        let (w, h) = (size[0] / 2.0 - inset, size[1] / 2.0 - inset);
        [[-w, -h], [w, -h], [w, h], [-w, h]].map(|[s, t]| {
            let p = [center[0] + s * facing, center[1] + t, center[2] + out * facing];
            (p, [s, t])
        })
    };
    // On the wall, outer edge, inner edge, canvas.
    let rings = [ring(0.0, -0.005), ring(0.012, 0.035), ring(0.052, 0.035), ring(0.064, 0.02)];
    let u = image as f64 / 4.0;
    let wood = Uv::Image([u + 61.5 / 256.0, 0.3, u + 62.5 / 256.0, 0.7], [1.0, 1.0]);
    for pair in rings.windows(2) {
        for k in 0..4 {
            let next = (k + 1) % 4;
            part.face(&[pair[0][k], pair[0][next], pair[1][next], pair[1][k]], wood);
        }
    }
    let canvas = [size[0] - 0.128, size[1] - 0.128];
    // Chart coordinates are centred; the image begins at its corner.
    let (du, dv) = (58.0 / 256.0 / 2.0, 0.49);
    let middle = [u + 0.5 / 256.0 + du, 0.5];
    let uv =
        Uv::Image([middle[0], middle[1] - dv, middle[0] + du, middle[1]], canvas.map(|c| c / 2.0));
    part.face(&rings[3], uv);
}

/// A rug before the doorway.
pub(super) fn rug() -> Part {
    let mut part = Part::new("rug", Look::Rug as usize);
    let (low, high) = ([0.9, 0.0, -0.55], [3.5, 0.014, 1.6]);
    cap(&mut part, low, high, 0.018, true, Uv::Image([0.0, 0.0, 1.0, 1.0], [2.6, 2.15]));
    part
}

pub(super) fn cube(part: &mut Part, low: P, size: P, color: usize) {
    let high = [low[0] + size[0], low[1] + size[1], low[2] + size[2]];
    block(part, low, high, 0.012, Ends::Top, Uv::Swatch(color));
}

pub(super) fn vase(part: &mut Part, base: P, size: f64, color: usize) {
    let profile = [
        [0.035, 0.28],
        [0.045, 0.32],
        [0.055, 0.325],
        [0.052, 0.29],
        [0.04, 0.25],
        [0.07, 0.18],
        [0.085, 0.12],
        [0.075, 0.06],
        [0.05, 0.015],
        [0.05, 0.0],
    ];
    lathe(part, base, &profile.map(|p| p.map(|v| v * size)), 16, Uv::Swatch(color));
    disc(part, [base[0], base[1] + 0.285 * size, base[2]], 0.04 * size, 13);
}

pub(super) fn bowl(part: &mut Part, base: P, color: usize) {
    // From the inside of the bottom over the rim to the foot.
    let profile =
        [[0.09, 0.035], [0.14, 0.09], [0.15, 0.10], [0.155, 0.095], [0.10, 0.02], [0.06, 0.0]];
    lathe(part, base, &profile, 20, Uv::Swatch(color));
    // Its rim lies within the bowl's wall.
    disc(part, [base[0], base[1] + 0.0355, base[2]], 0.1, color);
}

/// A flat disc that faces up, as one fan.
pub(super) fn disc(part: &mut Part, center: P, radius: f64, color: usize) {
    part.chart();
    let corners: Vec<_> = (0..12)
        .map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k) / 12.0;
            let (s, t) = (radius * angle.cos(), radius * angle.sin());
            ([center[0] + s, center[1], center[2] - t], [s, t])
        })
        .collect();
    part.face(&corners, Uv::Swatch(color));
}

pub(super) fn ball(part: &mut Part, center: P, radius: f64, color: usize) {
    let profile: Vec<_> = (0..=12)
        .map(|i| {
            let angle = std::f64::consts::PI * f64::from(i) / 12.0;
            [(radius * angle.sin()).max(0.0), radius * angle.cos()]
        })
        .collect();
    lathe(part, center, &profile, 20, Uv::Swatch(color));
}
