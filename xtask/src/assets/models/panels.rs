//! A surface cut into panels and laid flat, as a tailor would cover it with cloth: metres on the
//! body are metres in the picture.

use std::collections::HashMap;

use super::{mesh::Mesh, net::Net};
use crate::assets::part::{P, cross, distance, dot, normalize, sub};

/// The six directions that panels face. Upright panels run round the vertical axis without a turn;
/// top and bottom continue the panel that faces +x.
const FACING: [P; 6] = [
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
];

/// Directions of the cloth on a panel: to the right and up in the picture.
fn directions(panel: usize) -> [P; 2] {
    let normal = FACING[panel];
    let right = match panel {
        4 | 5 => [0.0, 0.0, -1.0],
        _ => cross([0.0, 1.0, 0.0], normal),
    };
    [right, cross(normal, right)]
}

/// How much nearer than the others a side panel may be: seams lie on the back and on the belly
/// rather than on the flanks.
const SIDES_FIRST: f64 = 0.16;
/// Rounds of straightening seams, of flattening.
const STRAIGHTEN: usize = 14;
const FLATTEN: usize = 400;

/// Cuts and flattens.
pub(super) fn panels(net: &Net) -> Mesh {
    let labels = labels(net);
    let mut mesh = Mesh::default();
    // A vertex of the net becomes one vertex a panel that touches it.
    let mut vertex_of: HashMap<(usize, usize), usize> = HashMap::new();
    let mut flat: Vec<[f64; 2]> = Vec::new();
    let mut panel_of = Vec::new();
    let quads: Vec<[usize; 4]> = net
        .quads
        .iter()
        .zip(&labels)
        .map(|(quad, &label)| {
            quad.map(|v| {
                *vertex_of.entry((v, label)).or_insert_with(|| {
                    let p = net.positions[v];
                    let [right, up] = directions(label);
                    mesh.positions.push(p);
                    mesh.normals.push(net.normals[v]);
                    flat.push([dot(p, right), -dot(p, up)]);
                    panel_of.push(label);
                    flat.len() - 1
                })
            })
        })
        .collect();
    lay_flat(&mesh.positions, &mut flat, &quads);
    mesh.uvs = flat;
    for &[a, b, c, d] in &quads {
        let p = |i: usize| mesh.positions[i];
        if distance(p(a), p(c)) <= distance(p(b), p(d)) {
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        } else {
            mesh.triangles.extend([[a, b, d], [b, c, d]]);
        }
    }
    mesh.tangents_from_uvs();
    mesh
}

/// The panel of every quad.
fn labels(net: &Net) -> Vec<usize> {
    let normals: Vec<P> = net
        .quads
        .iter()
        .map(|q| {
            let [a, b, c, d] = q.map(|v| net.positions[v]);
            normalize(cross(sub(c, a), sub(d, b)))
        })
        .collect();
    let nearness = |i: usize, panel: usize| {
        dot(normals[i], FACING[panel]) + if panel < 2 { SIDES_FIRST } else { 0.0 }
    };
    let mut around: HashMap<usize, Vec<usize>> = HashMap::new();
    for (i, quad) in net.quads.iter().enumerate() {
        for &v in quad {
            around.entry(v).or_default().push(i);
        }
    }
    let best = |scores: [f64; 6]| {
        (1..6).fold(0, |best, k| if scores[k] > scores[best] { k } else { best })
    };
    let mut labels: Vec<usize> = (0..net.quads.len())
        .map(|i| best([0, 1, 2, 3, 4, 5].map(|panel| nearness(i, panel))))
        .collect();
    // Seams become short: a quad goes with its neighbours unless it faces another way altogether.
    for _ in 0..STRAIGHTEN {
        labels = (0..labels.len())
            .map(|i| {
                let mut scores = [0, 1, 2, 3, 4, 5].map(|panel| {
                    let near = nearness(i, panel);
                    if near < 0.25 { -9.0 } else { near }
                });
                for v in net.quads[i] {
                    for &j in &around[&v] {
                        scores[labels[j]] += 0.11;
                    }
                }
                best(scores)
            })
            .collect();
    }
    labels
}

/// Moves points of the plane until edges and diagonals have the length that they have on the body.
fn lay_flat(positions: &[P], flat: &mut [[f64; 2]], quads: &[[usize; 4]]) {
    let mut springs = Vec::new();
    for q in quads {
        let pairs =
            [(q[0], q[1]), (q[1], q[2]), (q[2], q[3]), (q[3], q[0]), (q[0], q[2]), (q[1], q[3])];
        springs.extend(pairs.map(|(a, b)| (a, b, distance(positions[a], positions[b]))));
    }
    for _ in 0..FLATTEN {
        for &(a, b, length) in &springs {
            let way = [flat[b][0] - flat[a][0], flat[b][1] - flat[a][1]];
            let now = (way[0] * way[0] + way[1] * way[1]).sqrt().max(1e-9);
            let step = 0.25 * (now - length) / now;
            for k in 0..2 {
                flat[a][k] += way[k] * step;
                flat[b][k] -= way[k] * step;
            }
        }
    }
}

/// Lengths in the picture divided by those on the body.
#[cfg(test)]
pub(super) fn stretch(mesh: &Mesh) -> Vec<f64> {
    let uv = |i: usize| [mesh.uvs[i][0], mesh.uvs[i][1], 0.0];
    let sides = mesh.triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
    sides
        .map(|(a, b)| distance(uv(a), uv(b)) / distance(mesh.positions[a], mesh.positions[b]))
        .collect()
}
