//! A room with two tall windows on the right and a small one behind, the object in its middle.

use super::ramp;
use crate::assets::part::{P, add, dot, scale, sub};

/// The room from corner to corner, the eye at the origin.
const LOW: P = [-3.2, -1.3, -3.6];
const HIGH: P = [3.0, 1.9, 3.4];
/// Windows: axis and side of the wall, then the ranges along the other two axes in their order.
const WINDOWS: [(usize, f64, [f64; 2], [f64; 2]); 3] = [
    (0, HIGH[0], [-0.6, 1.4], [0.35, 1.55]),
    (0, HIGH[0], [-0.6, 1.4], [1.85, 3.05]),
    (2, LOW[2], [-2.3, -1.5], [-0.1, 1.2]),
];
/// Ranges of the rug along x and z, and of the door in the wall that the object faces along x.
const RUG: [[f64; 2]; 2] = [[-1.6, 1.4], [-1.1, 1.1]];
const DOOR: [f64; 2] = [-2.2, -1.2];
/// Light that has been reflected more than once.
const AMBIENT: P = [0.16, 0.15, 0.14];

pub(super) fn radiance(d: P) -> P {
    // The wall that the ray meets.
    let (mut t, mut axis) = (f64::MAX, 0);
    for k in 0..3 {
        let edge = if d[k] > 0.0 { HIGH[k] } else { LOW[k] };
        if d[k].abs() > 1e-9 && edge / d[k] < t {
            (t, axis) = (edge / d[k], k);
        }
    }
    let p = scale(d, t);
    let side = if d[axis] > 0.0 { HIGH[axis] } else { LOW[axis] };
    for (window_axis, window_side, u, v) in WINDOWS {
        let [a, b] = others(window_axis);
        if axis == window_axis && side == window_side && within(p[a], u) && within(p[b], v) {
            return outside(d, (p[a] - u[0]) / (u[1] - u[0]), (p[b] - v[0]) / (v[1] - v[0]));
        }
    }
    let mut normal = [0.0; 3];
    normal[axis] = -d[axis].signum();
    let light = add(daylight(p, normal), scale(AMBIENT, openness(p, axis)));
    let albedo = albedo(p, axis, d[axis] > 0.0);
    [0, 1, 2].map(|k| albedo[k] * light[k])
}

/// How much of what is reflected more than once arrives: less towards edges and corners.
fn openness(p: P, axis: usize) -> f64 {
    others(axis).iter().fold(1.0, |open, &k| {
        let distance = (p[k] - LOW[k]).min(HIGH[k] - p[k]);
        open * (0.6 + 0.4 * ramp(-0.2, 0.9, distance))
    })
}

fn others(axis: usize) -> [usize; 2] {
    match axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

fn within(v: f64, [low, high]: [f64; 2]) -> bool {
    v > low && v < high
}

/// An overcast sky over a garden, behind the bars of a window; `u` and `v` go over it from 0 to 1.
fn outside(d: P, u: f64, v: f64) -> P {
    let bar = |t: f64| (t - 0.5).abs() < 0.02 || !(0.035..0.965).contains(&t);
    if bar(u) || bar(v) {
        return [0.5, 0.48, 0.45];
    }
    let sky = ramp(-0.12, 0.25, d[1]);
    [0, 1, 2].map(|k| {
        let garden = [0.9, 1.25, 0.6][k];
        garden + ([11.0, 12.0, 13.5][k] - garden) * sky
    })
}

/// Irradiance over pi of what comes through the windows, without shadows: 12 x 12 points a window.
fn daylight(p: P, normal: P) -> P {
    const N: usize = 12;
    let mut sum = [0.0; 3];
    for (axis, side, u, v) in WINDOWS {
        let [a, b] = others(axis);
        let area = (u[1] - u[0]) * (v[1] - v[0]) / (N * N) as f64;
        for i in 0..N * N {
            let mut q = [0.0; 3];
            q[axis] = side;
            q[a] = u[0] + (u[1] - u[0]) * ((i % N) as f64 + 0.5) / N as f64;
            q[b] = v[0] + (v[1] - v[0]) * ((i / N) as f64 + 0.5) / N as f64;
            let way = sub(q, p);
            // Near a window the points would show.
            let square = dot(way, way).max(0.12);
            let length = square.sqrt();
            let cosines = dot(way, normal).max(0.0) * way[axis].abs() / square;
            // From above comes sky, from below the garden.
            let sky = ramp(-0.3, 0.3, way[1] / length);
            let radiance = [0, 1, 2].map(|k| {
                let garden = [0.8, 0.9, 0.55][k];
                garden + ([11.0, 12.0, 13.5][k] - garden) * sky
            });
            sum = add(sum, scale(radiance, cosines * area / (square * std::f64::consts::PI)));
        }
    }
    sum
}

/// Boards and a rug on the floor, a door in front, a picture on the left wall, plaster with a skirting.
fn albedo(p: P, axis: usize, positive: bool) -> P {
    match (axis, positive) {
        (1, false) if within(p[0], RUG[0]) && within(p[2], RUG[1]) => {
            let edge = (p[0] - RUG[0][0])
                .min(RUG[0][1] - p[0])
                .min(p[2] - RUG[1][0])
                .min(RUG[1][1] - p[2]);
            let band = edge < 0.07 || within(edge, [0.14, 0.20]);
            if band { [0.58, 0.51, 0.40] } else { [0.27, 0.10, 0.09] }
        }
        (1, false) => {
            let board = (p[0] / 0.22).floor();
            let tone = 0.85 + 0.3 * (board * 0.618 - (board * 0.618).floor());
            let joint = if (p[0] / 0.22 - board) < 0.04 { 0.5 } else { 1.0 };
            [0.42, 0.27, 0.15].map(|c| c * tone * joint)
        }
        (1, true) => [0.82, 0.81, 0.78],
        // The skirting stands on the floor of every wall.
        (0 | 2, _) if p[1] < LOW[1] + 0.12 => [0.74, 0.72, 0.68],
        (2, true) if within(p[0], DOOR) && p[1] < 0.85 => {
            let (u, v) = ((p[0] - DOOR[0]) / (DOOR[1] - DOOR[0]), (p[1] - LOW[1]) / 2.15);
            let frame = !within(u, [0.07, 0.93]) || v > 0.96;
            let panel = within(u, [0.2, 0.8]) && (within(v, [0.1, 0.42]) || within(v, [0.5, 0.88]));
            let handle = within(u, [0.84, 0.9]) && within(v, [0.44, 0.47]);
            if handle {
                [0.25, 0.2, 0.12]
            } else if frame {
                [0.74, 0.72, 0.68]
            } else if panel {
                [0.30, 0.36, 0.36]
            } else {
                [0.36, 0.42, 0.42]
            }
        }
        (0, false) if within(p[1], [-0.2, 0.9]) && within(p[2], [-1.2, 0.6]) => {
            let frame = !within(p[1], [-0.13, 0.83]) || !within(p[2], [-1.13, 0.53]);
            let hill = p[1] < 0.25 + 0.1 * (p[2] * 3.0).sin();
            if frame {
                [0.12, 0.08, 0.05]
            } else if hill {
                [0.20, 0.30, 0.28]
            } else {
                [0.75, 0.55, 0.35]
            }
        }
        (0, false) => [0.52, 0.60, 0.58],
        _ => [0.72, 0.68, 0.60],
    }
}
