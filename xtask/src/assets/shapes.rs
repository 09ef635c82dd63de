//! Shapes that furniture is made of.

use std::f64::consts::TAU;

use super::part::{P, Part, Uv, add, scale};

/// Faces of a block that are there; the rest is hidden inside of something else.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Ends {
    /// Sides only.
    None,
    /// Sides and top.
    Top,
    /// All.
    Both,
}

/// An upright block with bevelled edges: the four sides are one strip chart, top and bottom one each.
pub(super) fn block(part: &mut Part, low: P, high: P, bevel: f64, ends: Ends, uv: Uv) {
    let top = ends != Ends::None;
    let bottom = ends == Ends::Both;
    let y = [low[1] + if bottom { bevel } else { 0.0 }, high[1] - if top { bevel } else { 0.0 }];
    let rim = rim(low, high, bevel);
    part.sweep(
        &[[0.0, y[1]], [0.0, y[0]]],
        9,
        uv,
        |j, [_, y]| [rim[j][0], y, rim[j][1]],
        |_, _| true,
    );
    if top {
        cap(part, low, high, bevel, true, uv);
    }
    if bottom {
        cap(part, low, high, bevel, false, uv);
    }
}

/// The outline of a block with bevelled vertical edges as x and z, counter-clockwise seen from above
/// (z points down), from the front left back to it.
fn rim(low: P, high: P, bevel: f64) -> [[f64; 2]; 9] {
    let ([x0, _, z0], [x1, _, z1], b) = (low, high, bevel);
    [
        [x0 + b, z1],
        [x1 - b, z1],
        [x1, z1 - b],
        [x1, z0 + b],
        [x1 - b, z0],
        [x0 + b, z0],
        [x0, z0 + b],
        [x0, z1 - b],
        [x0 + b, z1],
    ]
}

/// The top or bottom of a block with the bevel round it, as one flat chart.
pub(super) fn cap(part: &mut Part, low: P, high: P, bevel: f64, up: bool, uv: Uv) {
    part.chart();
    let rim = rim(low, high, bevel);
    let (edge, flat) = if up { (high[1] - bevel, high[1]) } else { (low[1] + bevel, low[1]) };
    let corner = |[x, z]: [f64; 2], y: f64| {
        ([x, y, z], [x - low[0], if up { high[2] - z } else { z - low[2] }])
    };
    let (x0, x1) = (low[0] + bevel, high[0] - bevel);
    let (z0, z1) = (low[2] + bevel, high[2] - bevel);
    let inner = [[x0, z1], [x1, z1], [x1, z0], [x0, z0]];
    let mut face = |mut corners: Vec<(P, [f64; 2])>| {
        if !up {
            corners.reverse();
        }
        part.face(&corners, uv);
    };
    face(inner.map(|p| corner(p, flat)).to_vec());
    for k in 0..4 {
        let next = (k + 1) % 4;
        let [a, b, c] = [0, 1, 2].map(|i| corner(rim[2 * k + i], edge));
        let [here, there] = [inner[k], inner[next]].map(|p| corner(p, flat));
        face(vec![a, b, there, here]);
        face(vec![b, c, there]);
    }
}

/// A board along x whose ends and back (low z) are hidden: top, front and bottom as one strip.
pub(super) fn shelf_board(part: &mut Part, low: P, high: P, bevel: f64, uv: Uv) {
    let (z0, z1) = (low[2], high[2]);
    let (y0, y1) = (low[1], high[1]);
    let profile = [
        [z0, y1],
        [z1 - bevel, y1],
        [z1, y1 - bevel],
        [z1, y0 + bevel],
        [z1 - bevel, y0],
        [z0, y0],
    ];
    let x = [low[0], high[0]];
    part.sweep(&profile, 2, uv, |j, [z, y]| [x[j], y, z], |_, _| true);
}

/// A beam along z under a ceiling: its top and ends are hidden.
pub(super) fn beam(part: &mut Part, low: P, high: P, bevel: f64, uv: Uv) {
    let (x0, x1) = (low[0], high[0]);
    let (y0, y1) = (low[1], high[1]);
    let profile = [
        [x0, y1],
        [x0, y0 + bevel],
        [x0 + bevel, y0],
        [x1 - bevel, y0],
        [x1, y0 + bevel],
        [x1, y1],
    ];
    let z = [low[2], high[2]];
    part.sweep(&profile, 2, uv, |j, [x, y]| [x, y, z[j]], |_, _| true);
}

/// A body of revolution about the y axis through `base`: `profile` holds radius and height, from the
/// top down.
pub(super) fn lathe(part: &mut Part, base: P, profile: &[[f64; 2]], segments: usize, uv: Uv) {
    part.sweep(
        profile,
        segments + 1,
        uv,
        |j, [r, y]| {
            // The last station is the first again, to the bit.
            let angle = TAU * (j % segments) as f64 / segments as f64;
            add(base, add([0.0, y, 0.0], scale([angle.sin(), 0.0, angle.cos()], r)))
        },
        |_, _| true,
    );
}
