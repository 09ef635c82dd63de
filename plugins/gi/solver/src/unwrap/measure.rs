//! How good a second UV set is: evenness, coverage, gutters.

use std::collections::HashMap;

use glam::{DVec2, UVec2, Vec2};

use crate::scene::Mesh;

/// Texels a unit of length over the surface: percentiles by area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Density {
    /// 5 % of the surface have less.
    pub p05: f32,
    /// The median.
    pub p50: f32,
    /// 5 % of the surface have more.
    pub p95: f32,
}

impl Density {
    /// How much more texels a unit of length the well served parts get than the badly served: 1 is even.
    /// Infinite where parts get none.
    #[must_use]
    pub fn spread(&self) -> f32 {
        if self.p05 > 0.0 { self.p95 / self.p05 } else { f32::INFINITY }
    }
}

/// Texel density of a second UV set whose square gets `size` texels. Zeros without a set or a surface.
#[must_use]
pub fn density(mesh: &Mesh, size: UVec2) -> Density {
    let size = size.as_dvec2();
    let mut shares: Vec<(f64, f64)> = Vec::with_capacity(mesh.triangles.len());
    let mut whole = 0.0;
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions.get(i as usize).copied());
        let [Some(a), Some(b), Some(c)] = [a, b, c] else { continue };
        let area = (b - a).as_dvec3().cross((c - a).as_dvec3()).length();
        let Some([a, b, c]) = uvs(mesh, *triangle, size) else { continue };
        if area > 0.0 && area.is_finite() {
            let texels = (b - a).perp_dot(c - a).abs();
            shares.push(((texels / area).sqrt(), area));
            whole += area;
        }
    }
    shares.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let percentile = |share: f64| {
        let mut sum = 0.0;
        for (density, area) in &shares {
            sum += area;
            if sum >= share * whole {
                return *density as f32;
            }
        }
        0.0
    };
    Density { p05: percentile(0.05), p50: percentile(0.5), p95: percentile(0.95) }
}

/// Share of the square that a second UV set without overlaps covers.
#[must_use]
pub fn coverage(mesh: &Mesh) -> f32 {
    let area = |triangle: &[u32; 3]| {
        uvs(mesh, *triangle, DVec2::ONE)
            .map_or(0.0, |[a, b, c]| (b - a).perp_dot(c - a).abs() / 2.0)
    };
    mesh.triangles.iter().map(area).sum::<f64>() as f32
}

fn uvs(mesh: &Mesh, triangle: [u32; 3], size: DVec2) -> Option<[DVec2; 3]> {
    let [a, b, c] =
        triangle.map(|i| mesh.uv1.get(i as usize).map(|uv: &Vec2| uv.as_dvec2() * size));
    Some([a?, b?, c?])
}

/// Smallest distance in texels between two charts of a second UV set whose square gets `size` texels;
/// `far` if none is nearer than that. Charts that overlap have a distance of 0. `charts` is the chart
/// of each triangle ([`charts`](super::charts)).
#[must_use]
pub fn gutter(mesh: &Mesh, charts: &[u32], size: UVec2, far: f32) -> f32 {
    let borders = borders(mesh, charts, size.as_dvec2());
    // Whoever is nearer than `far` meets in a cell: each edge is entered with half of that around it.
    let cell = f64::from(far).max(1.0);
    let mut cells: HashMap<[i32; 2], Vec<u32>> = HashMap::new();
    for (i, border) in borders.iter().enumerate() {
        border.cells(cell, f64::from(far) / 2.0, |at| cells.entry(at).or_default().push(i as u32));
    }
    let mut nearest = f64::from(far);
    for found in cells.values() {
        for (k, &i) in found.iter().enumerate() {
            for &j in &found[..k] {
                let [a, b] = [i, j].map(|i| &borders[i as usize]);
                if a.chart != b.chart {
                    nearest = nearest.min(a.distance(b));
                }
            }
        }
        if nearest <= 0.0 {
            break;
        }
    }
    nearest as f32
}

/// An edge of one triangle only of its chart.
struct Border {
    chart: u32,
    ends: [DVec2; 2],
}

fn borders(mesh: &Mesh, charts: &[u32], size: DVec2) -> Vec<Border> {
    let mut edges: HashMap<(u32, [[u32; 2]; 2]), u32> = HashMap::new();
    let key = |chart: u32, ends: [u32; 2]| {
        let mut ends = ends.map(|i| {
            let uv = mesh.uv1.get(i as usize).copied().unwrap_or_default() + Vec2::ZERO;
            uv.to_array().map(f32::to_bits)
        });
        ends.sort_unstable();
        (chart, ends)
    };
    let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    // Triangles without an area in the square cover no texel.
    let area =
        |t: &[u32; 3]| uvs(mesh, *t, size).is_some_and(|[a, b, c]| (b - a).perp_dot(c - a) != 0.0);
    let shown = || mesh.triangles.iter().zip(charts).filter(|(triangle, _)| area(triangle));
    for (triangle, &chart) in shown() {
        for ends in sides(triangle) {
            *edges.entry(key(chart, ends)).or_insert(0) += 1;
        }
    }
    let mut borders = Vec::new();
    for (triangle, &chart) in shown() {
        for ends in sides(triangle) {
            if edges.get(&key(chart, ends)) == Some(&1) {
                let ends = ends.map(|i| mesh.uv1[i as usize].as_dvec2() * size);
                if ends.iter().all(|p| p.is_finite()) {
                    borders.push(Border { chart, ends });
                }
            }
        }
    }
    borders
}

impl Border {
    /// The cells within `reach` of the edge.
    fn cells(&self, cell: f64, reach: f64, mut visit: impl FnMut([i32; 2])) {
        let [a, b] = self.ends;
        let d = b - a;
        let row = |y: f64| (y / cell).floor() as i32;
        for y in row(a.y.min(b.y) - reach)..=row(a.y.max(b.y) + reach) {
            // The part of the edge that is near the row.
            let [from, to] = [f64::from(y) * cell - reach, f64::from(y + 1) * cell + reach];
            let (mut first, mut last) = (0.0, 1.0);
            if d.y != 0.0 {
                let [p, q] = [from, to].map(|y| (y - a.y) / d.y);
                first = p.min(q).clamp(0.0, 1.0);
                last = p.max(q).clamp(0.0, 1.0);
            }
            let [p, q] = [first, last].map(|t| a.x + d.x * t);
            for x in row(p.min(q) - reach)..=row(p.max(q) + reach) {
                visit([x, y]);
            }
        }
    }

    fn distance(&self, other: &Self) -> f64 {
        let [a, b] = self.ends;
        let [c, d] = other.ends;
        let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
        let cross = side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
        if cross {
            return 0.0;
        }
        let ends = [(a, c, d), (b, c, d), (c, a, b), (d, a, b)];
        ends.into_iter().fold(f64::INFINITY, |nearest, (p, a, b)| nearest.min(distance(p, a, b)))
    }
}

/// Distance of a point from a line segment.
fn distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(d) / d.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(a + d * t)
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::unwrap::charts;

    /// Two squares of one metre; the second has half of the edges and stands `gap` beside the first.
    fn two(gap: f32) -> Mesh {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vec2::from);
        let place = |z: f32| square.map(|p: Vec2| p.extend(z));
        let first = square.map(|p| p * 0.5);
        let second = square.map(|p| p * 0.25 + Vec2::new(0.5 + gap, 0.1));
        Mesh {
            positions: [place(0.0), place(2.0)].concat(),
            uv1: [first, second].concat(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..Default::default()
        }
    }

    #[test]
    fn density_is_that_of_the_surface() {
        let found = density(&two(0.1), UVec2::splat(64));
        assert!((found.p05 - 16.0).abs() < 0.01 && (found.p95 - 32.0).abs() < 0.01, "{found:?}");
        assert!((found.spread() - 2.0).abs() < 1e-3);
        // A rectangle stretches.
        let found = density(&two(0.1), UVec2::new(64, 16));
        assert!((found.p95 - 16.0).abs() < 0.01, "{found:?}");
        assert!((coverage(&two(0.1)) - 0.3125).abs() < 1e-6);
        assert_eq!(density(&Mesh::default(), UVec2::ONE), Density::default());
        assert_eq!(Density::default().spread(), f32::INFINITY);
    }

    #[test]
    fn gutters_are_measured_between_edges() {
        let at = |gap: f32| {
            let mesh = two(gap);
            gutter(&mesh, &charts(&mesh), UVec2::splat(64), 4.0)
        };
        assert!((at(1.5 / 64.0) - 1.5).abs() < 1e-4, "{}", at(1.5 / 64.0));
        assert_eq!(at(0.2), 4.0);
        assert_eq!(at(0.0), 0.0);
        // Across each other, without a corner near.
        assert_eq!(at(-0.1), 0.0);
    }
}
