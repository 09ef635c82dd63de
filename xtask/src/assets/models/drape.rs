//! A square of heavy cloth that has fallen over a ball: particles and constraints, small steps
//! (Macklin et al., *Small Steps in Physics Simulation*, SCA 2019).

use std::collections::HashMap;

use super::{animals::bead, mesh::Mesh};
use crate::assets::part::{P, add, dot, scale, sub};

/// Particles along an edge, metres between two.
const N: usize = 80;
const SPACING: f64 = 0.68 / (N - 1) as f64;
/// The ball.
const CENTRE: P = [0.0, 0.15, 0.0];
const RADIUS: f64 = 0.13;
/// Layers of cloth stay so far apart.
const THICKNESS: f64 = 0.0085;
const STEP: f64 = 1.0 / 600.0;
const STEPS: usize = 1700;
/// Every so many steps the pairs that may touch are looked up anew.
const PAIRS_KEPT: usize = 10;

/// A distance that two particles keep, and how much it gives (metres a newton for one kilogram).
struct Rod {
    ends: [usize; 2],
    length: f64,
    compliance: f64,
}

/// The cloth at rest. The first UV set is the square before it fell, in metres.
pub(super) fn drape() -> Mesh {
    let rods = rods();
    let mut now: Vec<P> = (0..N * N).map(start).collect();
    let mut before = now.clone();
    let mut pairs = Vec::new();
    for step in 0..STEPS {
        // It swings for two thirds of the time and comes to rest in the last third.
        let keep = if step < STEPS * 2 / 3 { 0.9995 } else { 0.985 };
        for (p, q) in now.iter_mut().zip(&mut before) {
            let mut velocity = scale(sub(*p, *q), keep);
            velocity[1] -= 9.81 * STEP * STEP;
            *q = *p;
            *p = add(*p, velocity);
        }
        if step % PAIRS_KEPT == 0 {
            pairs = close_pairs(&now);
        }
        for rod in &rods {
            let [a, b] = rod.ends;
            let way = sub(now[b], now[a]);
            let length = dot(way, way).sqrt().max(1e-9);
            let push = (length - rod.length) / (2.0 + rod.compliance / (STEP * STEP)) / length;
            now[a] = add(now[a], scale(way, push));
            now[b] = sub(now[b], scale(way, push));
        }
        for &(a, b) in &pairs {
            let way = sub(now[b], now[a]);
            let length = dot(way, way).sqrt().max(1e-9);
            if length < THICKNESS {
                let push = 0.5 * (length - THICKNESS) / length;
                now[a] = add(now[a], scale(way, push));
                now[b] = sub(now[b], scale(way, push));
            }
        }
        for (p, q) in now.iter_mut().zip(&mut before) {
            collide(p, q);
        }
    }
    mesh(&smooth(now))
}

/// What lies under it: an egg inside of the ball and the cloth, so that no gap lets see through.
pub(super) fn form() -> Mesh {
    bead([0.0, 0.125, 0.0], [0.122, 0.123, 0.122])
}

/// Where a particle starts: on a flat square above the ball, a little turned and shifted, so that
/// the folds do not mirror each other.
fn start(i: usize) -> P {
    let half = (N - 1) as f64 / 2.0;
    let (x, z) = ((i % N) as f64 - half, (i / N) as f64 - half);
    // A turn by the angle whose tangent is 1/4.
    let (c, s) = (4.0 / 17.0_f64.sqrt(), 1.0 / 17.0_f64.sqrt());
    let wobble = ((i * 7919 + i / N * 104_729) % 1009) as f64 / 1009.0;
    [
        (c * x - s * z) * SPACING + 0.004,
        CENTRE[1] + RADIUS + THICKNESS + 0.002 * wobble,
        (s * x + c * z) * SPACING - 0.003,
    ]
}

/// Threads that hardly stretch, diagonals that give (cloth shears), pairs two apart against
/// sharp bends.
fn rods() -> Vec<Rod> {
    let kinds: [([isize; 2], f64); 6] = [
        ([1, 0], 0.0),
        ([0, 1], 0.0),
        ([1, 1], 2e-5),
        ([1, -1], 2e-5),
        ([2, 0], 6e-5),
        ([0, 2], 6e-5),
    ];
    let mut rods = Vec::new();
    for ([dx, dz], compliance) in kinds {
        for i in 0..N * N {
            let (x, z) = ((i % N) as isize + dx, (i / N) as isize + dz);
            if (0..N as isize).contains(&x) && (0..N as isize).contains(&z) {
                let length = SPACING * ((dx * dx + dz * dz) as f64).sqrt();
                rods.push(Rod { ends: [i, z as usize * N + x as usize], length, compliance });
            }
        }
    }
    rods
}

/// Pairs that may come closer than the thickness soon and are not next to each other in the cloth.
fn close_pairs(now: &[P]) -> Vec<(usize, usize)> {
    const REACH: f64 = THICKNESS * 1.6;
    let cell = |p: P| p.map(|v| (v / REACH).floor() as i32);
    let mut cells: HashMap<[i32; 3], Vec<usize>> = HashMap::new();
    for (i, &p) in now.iter().enumerate() {
        cells.entry(cell(p)).or_default().push(i);
    }
    let mut pairs = Vec::new();
    for (a, &p) in now.iter().enumerate() {
        let [x, y, z] = cell(p);
        for k in 0..27 {
            let near = [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1];
            for &b in cells.get(&near).map_or(&[][..], Vec::as_slice) {
                let apart = (a % N).abs_diff(b % N).max((a / N).abs_diff(b / N));
                let way = sub(now[b], p);
                if b > a && apart > 1 && dot(way, way) < REACH * REACH {
                    pairs.push((a, b));
                }
            }
        }
    }
    pairs
}

/// Keeps a particle out of the ball and above the ground; both hold it by friction.
fn collide(p: &mut P, before: &mut P) {
    let way = sub(*p, CENTRE);
    let distance = dot(way, way).sqrt().max(1e-9);
    let reach = RADIUS + THICKNESS * 0.5;
    if distance < reach {
        *p = add(CENTRE, scale(way, reach / distance));
        rub(*p, before, 0.3);
    }
    if p[1] < 0.002 {
        p[1] = 0.002;
        rub(*p, before, 0.25);
    }
}

/// Takes a share of what a particle moved in this step.
fn rub(p: P, before: &mut P, share: f64) {
    *before = add(*before, scale(sub(p, *before), share));
}

/// Evens out what is finer than a fold.
fn smooth(mut now: Vec<P>) -> Vec<P> {
    for _ in 0..2 {
        now = (0..N * N)
            .map(|i| {
                let (x, z) = (i % N, i / N);
                let mut sum = scale(now[i], 4.0);
                let mut count = 4.0;
                let edge = x == 0 || z == 0 || x == N - 1 || z == N - 1;
                if x > 0 && x < N - 1 {
                    sum = add(sum, add(now[i - 1], now[i + 1]));
                    count += 2.0;
                }
                if z > 0 && z < N - 1 {
                    sum = add(sum, add(now[i - N], now[i + N]));
                    count += 2.0;
                }
                if edge && count < 5.0 { now[i] } else { scale(sum, 1.0 / count) }
            })
            .collect();
    }
    now
}

fn mesh(now: &[P]) -> Mesh {
    let mut mesh = Mesh { positions: now.to_vec(), ..Mesh::default() };
    mesh.uvs = (0..N * N).map(|i| [(i % N) as f64 * SPACING, (i / N) as f64 * SPACING]).collect();
    for z in 0..N - 1 {
        for x in 0..N - 1 {
            let a = z * N + x;
            mesh.triangles.extend([[a, a + N, a + N + 1], [a, a + N + 1, a + 1]]);
        }
    }
    mesh.normals_from_triangles();
    mesh.tangents_from_uvs();
    mesh
}
