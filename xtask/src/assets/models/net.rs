//! A distance function as quads of even size: surface nets (S. F. Frisken Gibson, *Constrained
//! Elastic Surface Nets*, MICCAI 1998), then some rounds of evening out.

use std::collections::HashMap;

use super::solid::Solid;
use crate::assets::part::{P, add, dot, scale, sub};

/// A closed surface.
pub(super) struct Net {
    pub(super) positions: Vec<P>,
    pub(super) normals: Vec<P>,
    /// Four corners a face, counter-clockwise from outside.
    pub(super) quads: Vec<[usize; 4]>,
}

/// Rounds of moving vertices between their neighbours.
const ROUNDS: usize = 6;

/// The surface of `solid` inside the box from `low` to `high`, with cells of edge `cell`.
pub(super) fn net(solid: &Solid, low: P, high: P, cell: f64) -> Net {
    let counts = [0, 1, 2].map(|k| ((high[k] - low[k]) / cell).ceil() as usize + 1);
    let place = |c: [usize; 3]| [0, 1, 2].map(|k| low[k] + c[k] as f64 * cell);
    let index = |c: [usize; 3]| (c[2] * counts[1] + c[1]) * counts[0] + c[0];
    let mut values = vec![0.0; counts[0] * counts[1] * counts[2]];
    let all = |less: usize| {
        let n = counts.map(|n| n - less);
        (0..n[2]).flat_map(move |z| (0..n[1]).flat_map(move |y| (0..n[0]).map(move |x| [x, y, z])))
    };
    for c in all(0) {
        values[index(c)] = solid.distance(place(c));
    }
    let value = |c: [usize; 3]| values[index(c)];

    // One vertex a cell that the surface passes, at the mean of where it crosses the cell's edges.
    let mut positions = Vec::new();
    let mut vertex_of = HashMap::new();
    for c in all(1) {
        let (mut sum, mut crossings) = ([0.0; 3], 0.0);
        for axis in 0..3 {
            for corner in 0..4 {
                let mut from = c;
                from[(axis + 1) % 3] += corner & 1;
                from[(axis + 2) % 3] += corner >> 1;
                let mut to = from;
                to[axis] += 1;
                let (a, b) = (value(from), value(to));
                if (a < 0.0) != (b < 0.0) {
                    let t = a / (a - b);
                    sum = add(sum, add(scale(place(from), 1.0 - t), scale(place(to), t)));
                    crossings += 1.0;
                }
            }
        }
        if crossings > 0.0 {
            vertex_of.insert(c, positions.len());
            positions.push(scale(sum, 1.0 / crossings));
        }
    }

    // One quad an edge that the surface crosses, between the four cells around it.
    let mut quads = Vec::new();
    for c in all(1) {
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut to = c;
            to[axis] += 1;
            let inside = value(c) < 0.0;
            if inside == (value(to) < 0.0) || c[u] == 0 || c[v] == 0 {
                continue;
            }
            let cell = |du: usize, dv: usize| {
                let mut cell = c;
                cell[u] -= du;
                cell[v] -= dv;
                vertex_of[&cell]
            };
            let mut quad = [cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)];
            if !inside {
                quad.reverse();
            }
            quads.push(quad);
        }
    }
    even_out(solid, &mut positions, &quads);
    let normals = positions.iter().map(|&p| solid.normal(p)).collect();
    Net { positions, normals, quads }
}

/// Moves vertices to the middle of their neighbours, along the surface.
fn even_out(solid: &Solid, positions: &mut Vec<P>, quads: &[[usize; 4]]) {
    for _ in 0..ROUNDS {
        let mut sums = vec![([0.0; 3], 0.0); positions.len()];
        for quad in quads {
            for k in 0..4 {
                let next = positions[quad[(k + 1) % 4]];
                let sum = &mut sums[quad[k]];
                *sum = (add(sum.0, next), sum.1 + 1.0);
            }
        }
        *positions = positions
            .iter()
            .zip(sums)
            .map(|(&p, (sum, count))| {
                let way = sub(scale(sum, 1.0 / count), p);
                let normal = solid.normal(p);
                let along = sub(way, scale(normal, dot(way, normal)));
                solid.onto(add(p, scale(along, 0.5)))
            })
            .collect();
    }
}
