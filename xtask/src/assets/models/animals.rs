//! A rabbit and a hippopotamus, stuffed and sewn.

use std::f64::consts::{PI, TAU};

use super::{mesh::Mesh, net::net, panels::panels, solid::Solid};
use crate::assets::part::{P, add, cross, normalize, scale};

/// One unit of the plans is so many metres.
const UNIT: f64 = 0.1;
/// Left and right.
const SIDES: [f64; 2] = [-1.0, 1.0];
const UP: P = [0.0, 1.0, 0.0];
const RIGHT: P = [1.0, 0.0, 0.0];

/// Cloth and the beads of eyes and nose.
pub(super) type Toy = [Mesh; 2];

/// A sitting rabbit, 0.33 m to the tips of its ears, facing +z.
pub(super) fn bunny() -> Toy {
    let mut body = Solid::default();
    body.egg([0.0, 0.78, -0.38], [0.80, 0.78, 0.88], 0.1);
    body.egg([0.0, 0.92, 0.30], [0.60, 0.78, 0.62], 0.35);
    body.limb(([0.0, 1.15, 0.38], 0.46), ([0.0, 1.62, 0.58], 0.36), 0.3);
    // Head, cheeks, muzzle.
    body.egg([0.0, 1.92, 0.70], [0.47, 0.45, 0.52], 0.22);
    body.egg([0.0, 1.76, 1.08], [0.27, 0.23, 0.25], 0.2);
    for side in SIDES {
        body.egg([0.22 * side, 1.74, 0.92], [0.25, 0.23, 0.25], 0.15);
        // Sockets, so that the beads sit in the cloth.
        let eye = [0.385 * side, 2.0, 0.95];
        body.cut_egg(eye, UP, RIGHT, [0.09, 0.09, 0.09], 0.1);
        // Thigh, hind foot, foreleg, paw.
        body.egg([0.62 * side, 0.60, -0.26], [0.34, 0.57, 0.62], 0.06);
        body.limb(([0.62 * side, 0.15, -0.35], 0.16), ([0.66 * side, 0.15, 0.52], 0.15), 0.12);
        body.limb(([0.27 * side, 0.85, 0.66], 0.22), ([0.25 * side, 0.2, 0.90], 0.15), 0.14);
        body.egg([0.25 * side, 0.13, 0.99], [0.16, 0.13, 0.23], 0.08);
        // An ear, hollow in front.
        let (root, tip) = ([0.17 * side, 2.26, 0.58], [0.40 * side, 3.32, 0.20]);
        let up = normalize([tip[0] - root[0], tip[1] - root[1], tip[2] - root[2]]);
        let across = [1.0, 0.0, -0.35 * side];
        let front = normalize(cross(across, up));
        let front = scale(front, if front[2] < 0.0 { -1.0 } else { 1.0 });
        let middle = scale(add(root, tip), 0.5);
        body.turned_egg(middle, up, across, [0.215, 0.62, 0.105], 0.12);
        // A rib to the tip, which would be too thin for the net.
        body.limb((root, 0.09), (add(middle, scale(up, 0.55)), 0.075), 0.1);
        let hollow = add(add(middle, scale(front, 0.12)), scale(up, 0.02));
        body.cut_egg(hollow, up, across, [0.13, 0.44, 0.07], 0.07);
    }
    body.egg([0.0, 0.62, -1.30], [0.25, 0.25, 0.24], 0.08);
    let cloth = panels(&net(&body, [-1.2, -0.2, -1.75], [1.2, 3.6, 1.6], 0.0735));

    let mut beads = Mesh::default();
    for side in SIDES {
        beads.join(bead([0.345 * side, 2.0, 0.93], [0.085, 0.092, 0.085]));
    }
    beads.join(bead([0.0, 1.86, 1.31], [0.085, 0.06, 0.06]));
    [cloth.scale(UNIT), beads.scale(UNIT)]
}

/// A standing hippopotamus, 0.4 m long, facing +z.
pub(super) fn hippo() -> Toy {
    let mut body = Solid::default();
    body.egg([0.0, 1.22, -0.25], [0.86, 0.80, 1.25], 0.1);
    body.egg([0.0, 0.98, -0.15], [0.80, 0.68, 1.02], 0.25);
    body.limb(([0.0, 1.30, 0.62], 0.66), ([0.0, 1.42, 1.30], 0.48), 0.3);
    // Skull, muzzle, lower jaw with a line for the mouth.
    body.egg([0.0, 1.55, 1.48], [0.50, 0.45, 0.56], 0.25);
    body.limb(([0.0, 1.45, 1.60], 0.42), ([0.0, 1.28, 2.15], 0.40), 0.2);
    body.egg([0.0, 1.25, 2.22], [0.60, 0.40, 0.44], 0.2);
    body.egg([0.0, 0.91, 1.95], [0.47, 0.24, 0.57], 0.05);
    for side in SIDES {
        // Lips hang over the jaw, nostrils stand up.
        body.egg([0.34 * side, 1.17, 2.34], [0.30, 0.34, 0.30], 0.12);
        body.egg([0.25 * side, 1.57, 2.36], [0.15, 0.12, 0.15], 0.1);
        body.cut_egg([0.25 * side, 1.66, 2.46], UP, RIGHT, [0.065, 0.07, 0.09], 0.06);
        // Brows, eyes, ears.
        body.egg([0.31 * side, 1.93, 1.62], [0.17, 0.15, 0.17], 0.12);
        body.cut_egg([0.42 * side, 1.96, 1.73], UP, RIGHT, [0.08, 0.08, 0.08], 0.06);
        let up = normalize([0.45 * side, 1.0, -0.15]);
        let ear = [0.43 * side, 2.06, 1.18];
        body.turned_egg(ear, up, [1.0, 0.0, 0.25 * side], [0.16, 0.22, 0.095], 0.1);
        let hollow = add(ear, [0.02 * side, 0.03, 0.10]);
        body.cut_egg(hollow, up, [1.0, 0.0, 0.25 * side], [0.10, 0.14, 0.06], 0.06);
        for (z, knee) in [(0.62, 0.70), (-0.98, -0.95)] {
            let hip = [0.45 * side, 0.9, knee];
            body.limb((hip, 0.40), ([0.50 * side, 0.24, z], 0.27), 0.2);
            body.egg([0.51 * side, 0.13, z + 0.06], [0.31, 0.14, 0.33], 0.1);
        }
    }
    // A tail that hangs.
    body.limb(([0.0, 1.42, -1.42], 0.12), ([0.0, 1.05, -1.62], 0.075), 0.15);
    body.egg([0.0, 0.95, -1.65], [0.10, 0.15, 0.09], 0.06);
    let cloth = panels(&net(&body, [-1.2, -0.2, -1.95], [1.2, 2.6, 2.95], 0.083));

    let mut beads = Mesh::default();
    for side in SIDES {
        beads.join(bead([0.37 * side, 1.955, 1.70], [0.08, 0.085, 0.08]));
    }
    [cloth.scale(UNIT), beads.scale(UNIT)]
}

/// A smooth egg.
pub(super) fn bead(centre: P, radii: P) -> Mesh {
    const RINGS: usize = 10;
    const SEGMENTS: usize = 16;
    let mut mesh = Mesh::default();
    for i in 0..=RINGS {
        for j in 0..=SEGMENTS {
            let polar = PI * i as f64 / RINGS as f64;
            let turn = TAU * (j % SEGMENTS) as f64 / SEGMENTS as f64;
            let d = [polar.sin() * turn.sin(), polar.cos(), polar.sin() * turn.cos()];
            mesh.positions.push(add(centre, [0, 1, 2].map(|k| d[k] * radii[k])));
            mesh.normals.push(normalize([0, 1, 2].map(|k| d[k] / radii[k])));
            mesh.tangents.push([turn.cos(), 0.0, -turn.sin()]);
            let around = radii[0] * TAU * j as f64 / SEGMENTS as f64;
            mesh.uvs.push([around, radii[1] * polar]);
        }
    }
    for i in 0..RINGS {
        for j in 0..SEGMENTS {
            let [a, b] = [i * (SEGMENTS + 1) + j, (i + 1) * (SEGMENTS + 1) + j];
            if i > 0 {
                mesh.triangles.push([a, b, a + 1]);
            }
            if i + 1 < RINGS {
                mesh.triangles.push([a + 1, b, b + 1]);
            }
        }
    }
    mesh
}
