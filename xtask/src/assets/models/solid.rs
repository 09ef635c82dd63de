//! Bodies as distance functions: balls, eggs and limbs that flow into each other.
//!
//! Only additions, products, quotients and square roots, which are the same to the bit on every
//! machine.

use crate::assets::part::{P, cross, dot, normalize, scale, sub};

/// A simple body.
#[derive(Clone, Copy)]
enum Shape {
    /// Centre, three axes at right angles, radii along them.
    Egg(P, [P; 3], P),
    /// Two balls (centre, radius) and the cone that touches both.
    Limb(P, f64, P, f64),
}

/// How a shape joins what was there before.
#[derive(Clone, Copy)]
enum Join {
    Add,
    Cut,
}

/// Shapes, joined in their order.
#[derive(Default)]
pub(super) struct Solid(Vec<(Shape, Join, f64)>);

impl Solid {
    /// An egg whose axes are those of space; `blend` is the width over which it flows into the rest.
    pub(super) fn egg(&mut self, centre: P, radii: P, blend: f64) {
        self.turned_egg(centre, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], radii, blend);
    }

    /// The same, turned: its second radius points along `up`, its first as far along `right` as it can.
    pub(super) fn turned_egg(&mut self, centre: P, up: P, right: P, radii: P, blend: f64) {
        self.0.push((Shape::Egg(centre, frame(up, right), radii), Join::Add, blend));
    }

    /// Takes an egg away.
    pub(super) fn cut_egg(&mut self, centre: P, up: P, right: P, radii: P, blend: f64) {
        self.0.push((Shape::Egg(centre, frame(up, right), radii), Join::Cut, blend));
    }

    /// A limb from one ball to another.
    pub(super) fn limb(&mut self, from: (P, f64), to: (P, f64), blend: f64) {
        self.0.push((Shape::Limb(from.0, from.1, to.0, to.1), Join::Add, blend));
    }

    /// Roughly the distance from the surface, negative inside.
    pub(super) fn distance(&self, p: P) -> f64 {
        let mut all = 1e9;
        for &(shape, join, blend) in &self.0 {
            let d = shape.distance(p);
            all = match join {
                Join::Add => smooth_min(all, d, blend),
                Join::Cut => -smooth_min(-all, d, blend),
            };
        }
        all
    }

    /// The direction in which the distance grows.
    pub(super) fn normal(&self, p: P) -> P {
        const E: f64 = 1e-4;
        let along = |k: usize| {
            let (mut low, mut high) = (p, p);
            low[k] -= E;
            high[k] += E;
            self.distance(high) - self.distance(low)
        };
        normalize([along(0), along(1), along(2)])
    }

    /// Moves a point that is near the surface onto it.
    pub(super) fn onto(&self, mut p: P) -> P {
        for _ in 0..4 {
            const E: f64 = 1e-4;
            let n = self.normal(p);
            let (out, inner) = (offset(p, n, E), offset(p, n, -E));
            let slope = (self.distance(out) - self.distance(inner)) / (2.0 * E);
            p = offset(p, n, -self.distance(p) / slope.max(0.3));
        }
        p
    }
}

fn offset(p: P, direction: P, by: f64) -> P {
    [0, 1, 2].map(|k| p[k] + direction[k] * by)
}

fn frame(up: P, right: P) -> [P; 3] {
    let up = normalize(up);
    let right = normalize(sub(right, scale(up, dot(up, right))));
    [right, up, cross(right, up)]
}

/// The smaller of two distances, rounded off where they differ by less than `width`.
fn smooth_min(a: f64, b: f64, width: f64) -> f64 {
    let overlap = (1.0 - (a - b).abs() / width.max(1e-9)).max(0.0);
    a.min(b) - overlap * overlap * width * 0.25
}

impl Shape {
    fn distance(&self, p: P) -> f64 {
        let length = |v: P| dot(v, v).sqrt();
        match *self {
            // Exact on the surface and at first order beside it, which is all that is asked.
            Self::Egg(centre, axes, radii) => {
                let q = axes.map(|axis| dot(axis, sub(p, centre)));
                let near = length([0, 1, 2].map(|k| q[k] / radii[k]));
                let slope = length([0, 1, 2].map(|k| q[k] / (radii[k] * radii[k])));
                if slope < 1e-9 {
                    return -radii[0].min(radii[1]).min(radii[2]);
                }
                near * (near - 1.0) / slope
            }
            // The closest point of the axis is found as for a cylinder and moved along by the
            // cone's slope.
            Self::Limb(a, ra, b, rb) => {
                let axis = sub(b, a);
                let l = length(axis);
                let axis = scale(axis, 1.0 / l);
                let y = dot(sub(p, a), axis);
                let x = length(sub(sub(p, a), scale(axis, y)));
                let sine = (ra - rb) / l;
                let cosine = (1.0 - sine * sine).sqrt();
                let t = (y + x * sine / cosine).clamp(0.0, l);
                (x * x + (y - t) * (y - t)).sqrt() - (ra + (rb - ra) * t / l)
            }
        }
    }
}
