//! Which texels of a mesh's second UV square are covered, and by which points of its surface.
//!
//! Independent of transform and material, so the result is kept while these change.

use glam::{Vec2, Vec3};

use crate::scene::Mesh;
use crate::unwrap::charts;

/// No texel, no chart.
pub(crate) const NONE: u32 = u32::MAX;
/// Sample points a texel.
pub(crate) const SAMPLES: usize = 4;

/// Offsets of the sample points inside a texel: a rotated grid.
const OFFSETS: [Vec2; SAMPLES] = [
    Vec2::new(0.375, 0.125),
    Vec2::new(0.875, 0.375),
    Vec2::new(0.125, 0.625),
    Vec2::new(0.625, 0.875),
];
/// Texels covered less than this, centre not included, are left to dilation where the chart has a
/// better neighbour: their points would sit on the chart's very edge, often inside a wall.
const SLIVER: f32 = 0.05;

/// A point on a triangle of the mesh.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SurfacePoint {
    /// Triangle of the mesh.
    pub triangle: u32,
    /// Weights of its second and third corner.
    pub bary: Vec2,
}

/// The covered texels of a mesh's UV square at one resolution.
#[derive(Debug, Default)]
pub(crate) struct MeshTexels {
    pub width: u32,
    pub height: u32,
    /// `width * height`: number of the covered texel, or [`NONE`].
    pub index: Vec<u32>,
    /// Column and row of each covered texel.
    pub coords: Vec<[u16; 2]>,
    /// The point that stands for the texel: its centre, or where that is outside of the chart, or on
    /// a narrow face that looks elsewhere than most of the texel, the centroid of the largest part.
    pub points: Vec<SurfacePoint>,
    /// Points spread over the covered part; where one is outside, `points` stands in.
    pub samples: Vec<[SurfacePoint; SAMPLES]>,
    /// The chart of each covered texel.
    pub chart: Vec<u32>,
    /// The chart of each triangle.
    pub triangle_chart: Vec<u32>,
    /// For each covered texel, what [`triangles_in`](Self::triangles_in) gives: first and end.
    parts: Vec<[u32; 2]>,
    part_triangles: Vec<u32>,
}

/// Faces of a texel whose normals have at least this cosine between them look the same way.
const ALIKE: f32 = 0.9;

struct Fragment {
    texel: u32,
    chart: u32,
    triangle: u32,
    area: f32,
    centroid: Vec2,
}

impl MeshTexels {
    /// Rasterizes conservatively: every texel that a triangle touches.
    pub(crate) fn new(mesh: &Mesh, width: u32, height: u32) -> Self {
        let triangle_chart = charts(mesh);
        let size = Vec2::new(width as f32, height as f32);
        let corners =
            |triangle: u32| mesh.triangles[triangle as usize].map(|i| mesh.uv1[i as usize] * size);
        let mut fragments = Vec::new();
        for (triangle, &chart) in triangle_chart.iter().enumerate() {
            let corners = corners(triangle as u32);
            if corners.iter().all(|c| c.is_finite()) {
                rasterize(&corners, triangle as u32, chart, width, height, &mut fragments);
            }
        }
        fragments.sort_unstable_by_key(|f| (f.texel, f.chart, f.triangle));

        let mut texels = Self {
            width,
            height,
            index: vec![NONE; width as usize * height as usize],
            triangle_chart,
            ..Default::default()
        };
        let mut sliver = Vec::new();
        for group in fragments.chunk_by(|a, b| a.texel == b.texel) {
            let (x, y) = (group[0].texel % width, group[0].texel / width);
            let origin = Vec2::new(x as f32, y as f32);
            let inside = |fragments: &[Fragment], offset: Vec2| {
                fragments.iter().find_map(|f| {
                    let bary = barycentric(&corners(f.triangle), origin + offset)?;
                    Some(SurfacePoint { triangle: f.triangle, bary })
                })
            };
            // The chart at the texel's centre owns it, else the one that covers most.
            let Some((own, centre, area)) = group
                .chunk_by(|a, b| a.chart == b.chart)
                .map(|part| {
                    let area = part.iter().map(|f| f.area).sum::<f32>();
                    (part, inside(part, Vec2::splat(0.5)), area)
                })
                .max_by(|a, b| (a.1.is_some(), a.2).partial_cmp(&(b.1.is_some(), b.2)).unwrap())
            else {
                continue;
            };
            let alike = |f: &Fragment| {
                let normal = face_normal(mesh, f.triangle);
                let looks_there = |o: &&Fragment| face_normal(mesh, o.triangle).dot(normal) > ALIKE;
                own.iter().filter(looks_there).map(|o| o.area).sum::<f32>()
            };
            // A centre on a chamfer would make the whole texel look where the chamfer does.
            let typical = |p: &SurfacePoint| {
                let mut under = own.iter().filter(|f| f.triangle == p.triangle);
                own.len() == 1 || under.all(|f| alike(f) >= area * 0.5)
            };
            let point = centre.filter(typical).or_else(|| {
                let size = |f: &Fragment| (alike(f), f.area);
                let most = own.iter().max_by(|a, b| size(a).partial_cmp(&size(b)).unwrap())?;
                let corners = corners(most.triangle);
                let bary = barycentric_unclamped(&corners, most.centroid)?;
                Some(SurfacePoint { triangle: most.triangle, bary: clamp_inside(bary) })
            });
            let Some(point) = point else { continue };
            sliver.push(centre.is_none() && area < SLIVER);
            texels.index[group[0].texel as usize] = texels.points.len() as u32;
            texels.coords.push([x as u16, y as u16]);
            texels.points.push(point);
            texels.samples.push(OFFSETS.map(|offset| inside(own, offset).unwrap_or(point)));
            texels.chart.push(own[0].chart);
            let first = texels.part_triangles.len() as u32;
            let mut parts: Vec<&Fragment> = own.iter().collect();
            parts.sort_by(|a, b| b.area.total_cmp(&a.area));
            texels.part_triangles.extend(parts.iter().map(|f| f.triangle));
            texels.parts.push([first, texels.part_triangles.len() as u32]);
        }
        texels.drop_slivers(&sliver);
        texels
    }

    /// How many texels are covered.
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// The triangles that a covered texel holds parts of, the largest parts first.
    pub(crate) fn triangles_in(&self, texel: usize) -> &[u32] {
        let [first, end] = self.parts[texel].map(|i| i as usize);
        &self.part_triangles[first..end]
    }

    /// The covered texel that answers for a point with the given UV on a triangle: the one under it,
    /// or where that belongs to another chart the nearest around it that belongs to the right one.
    pub(crate) fn lookup(&self, triangle: u32, uv: Vec2) -> Option<u32> {
        let chart = self.triangle_chart[triangle as usize];
        let size = Vec2::new(self.width as f32, self.height as f32);
        // Far outside there is nothing, however far.
        let p = (uv * size).clamp(Vec2::splat(-2.0), size + 2.0);
        let (x, y) = (p.x.floor() as i64, p.y.floor() as i64);
        if let Some(texel) = self.at(x, y, chart) {
            return Some(texel);
        }
        let mut best = (f32::INFINITY, None);
        for dy in -1..=1 {
            for dx in -1..=1 {
                if let Some(texel) = self.at(x + dx, y + dy, chart) {
                    let centre = Vec2::new((x + dx) as f32 + 0.5, (y + dy) as f32 + 0.5);
                    let distance = centre.distance_squared(p);
                    if distance < best.0 {
                        best = (distance, Some(texel));
                    }
                }
            }
        }
        best.1
    }

    /// The covered texel at a place, if it belongs to the chart.
    pub(crate) fn at(&self, x: i64, y: i64, chart: u32) -> Option<u32> {
        if x < 0 || y < 0 || x >= i64::from(self.width) || y >= i64::from(self.height) {
            return None;
        }
        let texel = self.index[y as usize * self.width as usize + x as usize];
        (texel != NONE && self.chart[texel as usize] == chart).then_some(texel)
    }

    fn drop_slivers(&mut self, sliver: &[bool]) {
        let keep: Vec<bool> = (0..self.len())
            .map(|i| {
                let [x, y] = self.coords[i].map(i64::from);
                !sliver[i]
                    || !(-1..=1).any(|dy| {
                        (-1..=1).any(|dx| {
                            self.at(x + dx, y + dy, self.chart[i])
                                .is_some_and(|other| !sliver[other as usize])
                        })
                    })
            })
            .collect();
        let kept = |i: &mut usize| {
            *i += 1;
            keep[*i - 1]
        };
        let (mut a, mut b, mut c, mut d, mut e) = (0, 0, 0, 0, 0);
        self.coords.retain(|_| kept(&mut a));
        self.points.retain(|_| kept(&mut b));
        self.samples.retain(|_| kept(&mut c));
        self.chart.retain(|_| kept(&mut d));
        self.parts.retain(|_| kept(&mut e));
        self.index.fill(NONE);
        for (i, [x, y]) in self.coords.iter().enumerate() {
            self.index[usize::from(*y) * self.width as usize + usize::from(*x)] = i as u32;
        }
    }
}

/// Unit normal of a triangle in the mesh's space; zero if it has no area.
fn face_normal(mesh: &Mesh, triangle: u32) -> Vec3 {
    let [a, b, c] = mesh.triangles[triangle as usize].map(|i| mesh.positions[i as usize]);
    (b - a).cross(c - a).normalize_or_zero()
}

/// Adds a fragment for every texel that the triangle touches with some area.
fn rasterize(
    corners: &[Vec2; 3],
    triangle: u32,
    chart: u32,
    width: u32,
    height: u32,
    out: &mut Vec<Fragment>,
) {
    let size = Vec2::new(width as f32, height as f32);
    let low = corners[0].min(corners[1]).min(corners[2]).max(Vec2::ZERO).floor();
    let high = corners[0].max(corners[1]).max(corners[2]).min(size).ceil();
    for y in low.y as u32..high.y.max(0.0) as u32 {
        for x in low.x as u32..high.x.max(0.0) as u32 {
            let cell = Vec2::new(x as f32, y as f32);
            if let Some((area, centroid)) = clipped(corners, cell) {
                out.push(Fragment { texel: y * width + x, chart, triangle, area, centroid });
            }
        }
    }
}

/// Area and centroid of the part of a triangle that lies in the unit square at `cell`
/// (Sutherland and Hodgman 1974); `None` where there is none.
fn clipped(corners: &[Vec2; 3], cell: Vec2) -> Option<(f32, Vec2)> {
    let mut polygon = [Vec2::ZERO; 8];
    let mut count = 3;
    for (to, from) in polygon.iter_mut().zip(corners) {
        *to = *from - cell;
    }
    for side in 0..4 {
        let depth = |p: Vec2| match side {
            0 => p.x,
            1 => 1.0 - p.x,
            2 => p.y,
            _ => 1.0 - p.y,
        };
        let mut clipped = [Vec2::ZERO; 8];
        let mut kept = 0;
        for i in 0..count {
            let (a, b) = (polygon[i], polygon[(i + 1) % count]);
            let (da, db) = (depth(a), depth(b));
            if da >= 0.0 {
                clipped[kept] = a;
                kept += 1;
            }
            if (da >= 0.0) != (db >= 0.0) {
                clipped[kept] = a + (b - a) * (da / (da - db));
                kept += 1;
            }
        }
        (polygon, count) = (clipped, kept);
        if count < 3 {
            return None;
        }
    }
    let (mut doubled, mut moment) = (0.0, Vec2::ZERO);
    for i in 1..count - 1 {
        let part = (polygon[i] - polygon[0]).perp_dot(polygon[i + 1] - polygon[0]);
        doubled += part;
        moment += (polygon[0] + polygon[i] + polygon[i + 1]) * (part / 3.0);
    }
    let area = doubled.abs() * 0.5;
    (area > 1e-7).then(|| (area, moment / doubled + cell))
}

/// Weights of the second and third corner; `None` outside of the triangle.
pub(crate) fn barycentric(corners: &[Vec2; 3], p: Vec2) -> Option<Vec2> {
    barycentric_unclamped(corners, p).filter(|b| b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0)
}

fn barycentric_unclamped(corners: &[Vec2; 3], p: Vec2) -> Option<Vec2> {
    let (e1, e2, d) = (corners[1] - corners[0], corners[2] - corners[0], p - corners[0]);
    let area = e1.perp_dot(e2);
    let bary = Vec2::new(d.perp_dot(e2), e1.perp_dot(d)) / area;
    bary.is_finite().then_some(bary)
}

/// Pulls a point a little towards the middle of its triangle.
fn clamp_inside(bary: Vec2) -> Vec2 {
    let mut weights = [1.0 - bary.x - bary.y, bary.x, bary.y].map(|w| w.max(1e-3));
    let sum: f32 = weights.iter().sum();
    weights = weights.map(|w| w / sum);
    Vec2::new(weights[1], weights[2])
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn quad(low: Vec2, high: Vec2) -> Mesh {
        let uv1 = vec![low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)];
        Mesh {
            positions: uv1.iter().map(|uv| Vec3::new(uv.x, 0.0, uv.y)).collect(),
            uv1,
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Default::default()
        }
    }

    #[test]
    fn a_full_square_covers_every_texel_at_its_centre() {
        let mesh = quad(Vec2::ZERO, Vec2::ONE);
        let texels = MeshTexels::new(&mesh, 8, 4);
        assert_eq!(texels.len(), 32);
        for (i, [x, y]) in texels.coords.iter().enumerate() {
            let SurfacePoint { triangle, bary } = texels.points[i];
            let [a, b, c] = mesh.triangles[triangle as usize].map(|i| mesh.uv1[i as usize]);
            let uv = a + (b - a) * bary.x + (c - a) * bary.y;
            let centre = Vec2::new((f32::from(*x) + 0.5) / 8.0, (f32::from(*y) + 0.5) / 4.0);
            assert!(uv.distance(centre) < 1e-5);
            assert_eq!(texels.lookup(triangle, uv), Some(i as u32));
        }
    }

    #[test]
    fn partly_covered_texels_have_points_inside() {
        // Covers 2.3 to 6.8 texels: the outermost columns are only touched.
        let mesh = quad(Vec2::splat(2.3 / 8.0), Vec2::splat(6.8 / 8.0));
        let texels = MeshTexels::new(&mesh, 8, 8);
        assert_eq!(texels.len(), 25);
        for (point, samples) in texels.points.iter().zip(&texels.samples) {
            for p in samples.iter().chain([point]) {
                assert!(p.bary.x >= 0.0 && p.bary.y >= 0.0 && p.bary.x + p.bary.y <= 1.0);
            }
        }
        assert_eq!(texels.lookup(0, Vec2::splat(2.31 / 8.0)), texels.at(2, 2, 0));
    }

    #[test]
    fn slivers_are_left_to_dilation_but_still_found() {
        let mesh = quad(Vec2::ZERO, Vec2::new(4.02 / 8.0, 0.5));
        let texels = MeshTexels::new(&mesh, 8, 8);
        assert_eq!(texels.len(), 16);
        assert_eq!(texels.lookup(0, Vec2::new(4.01 / 8.0, 0.05)), texels.at(3, 0, 0));
    }

    /// A moulding crosses the only texel right under its centre: the texel looks where the wall does.
    #[test]
    fn a_chamfer_under_the_centre_does_not_stand_for_the_texel() {
        let rows = [(0.0, 0.0), (0.4, 0.0), (0.6, 0.3), (1.0, 0.3)];
        let corner = |(v, depth): (f32, f32), u| (Vec3::new(u, depth, v), Vec2::new(u, v));
        let (positions, uv1) =
            rows.iter().flat_map(|row| [corner(*row, 0.0), corner(*row, 1.0)]).unzip();
        let triangles =
            (0..3).flat_map(|i| [[2 * i, 2 * i + 1, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 2]]);
        let mesh = Mesh { positions, uv1, triangles: triangles.collect(), ..Default::default() };
        let texels = MeshTexels::new(&mesh, 1, 1);
        let chamfer = face_normal(&mesh, 2);
        assert!(chamfer.dot(face_normal(&mesh, 0)) < ALIKE);
        assert_eq!(face_normal(&mesh, texels.points[0].triangle), face_normal(&mesh, 0));
        let fine = MeshTexels::new(&mesh, 1, 10);
        assert_eq!(face_normal(&mesh, fine.points[5].triangle), chamfer);
    }

    #[test]
    fn neighbouring_charts_do_not_answer_for_each_other() {
        let (a, b) =
            (quad(Vec2::ZERO, Vec2::new(0.45, 1.0)), quad(Vec2::new(0.55, 0.0), Vec2::ONE));
        let mut mesh = a;
        mesh.positions.extend(b.positions.iter().map(|p| *p + Vec3::Y));
        mesh.uv1.extend(b.uv1);
        mesh.triangles.extend(b.triangles.iter().map(|t| t.map(|i| i + 4)));
        let texels = MeshTexels::new(&mesh, 4, 4);
        assert_ne!(texels.triangle_chart[0], texels.triangle_chart[2]);
        for (triangle, u) in [(0, 0.44), (2, 0.56)] {
            let texel = texels.lookup(triangle, Vec2::new(u, 0.1)).unwrap();
            assert_eq!(texels.chart[texel as usize], texels.triangle_chart[triangle as usize]);
        }
    }

    #[test]
    fn broken_uvs_are_no_trouble() {
        let mut mesh = quad(Vec2::ZERO, Vec2::ONE);
        mesh.uv1[0] = Vec2::new(f32::NAN, 0.0);
        mesh.uv1[1] = Vec2::splat(1e30);
        let _ = MeshTexels::new(&mesh, 4, 4);
        assert_eq!(MeshTexels::new(&quad(Vec2::ONE, Vec2::ONE), 4, 4).len(), 0);
        assert_eq!(MeshTexels::new(&quad(Vec2::splat(-3.0), Vec2::splat(-2.0)), 4, 4).len(), 0);
    }
}
