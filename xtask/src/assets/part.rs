//! Parts: meshes made of faces, sorted into lightmap charts.

use std::collections::HashMap;

use super::pack;

/// A position in metres.
pub(super) type P = [f64; 3];

/// Lightmap texels a metre that charts are laid out for: with more the demo scene does not fit a page
/// of 128 x 128.
const TEXELS_PER_METRE: f64 = 4.75;

/// A corner of a face.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) position: P,
    /// Metres in the plane of the chart.
    pub(super) chart: [f64; 2],
    /// First UV set.
    pub(super) uv: [f64; 2],
}

/// A triangle or convex quad, counter-clockwise from the front.
struct Face {
    corners: Vec<Corner>,
    chart: usize,
}

/// How the first UV set follows from chart coordinates.
#[derive(Clone, Copy)]
pub(super) enum Uv {
    /// Repeats every so many metres.
    Tile(f64),
    /// As `Tile`, with s and t exchanged (the grain of wood runs the other way).
    TileAcross(f64),
    /// One colour of a palette image of 16 x 1 pixels.
    Swatch(usize),
    /// The rectangle `[u0, v0, u1, v1]` of an image over a chart of this size in metres.
    Image([f64; 4], [f64; 2]),
}

impl Uv {
    pub(super) fn at(self, [s, t]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Tile(size) => [s / size, t / size],
            Self::TileAcross(size) => [t / size, s / size],
            Self::Swatch(i) => [(i as f64 + 0.5) / 16.0, 0.5],
            Self::Image([u0, v0, u1, v1], [w, h]) => {
                [u0 + (u1 - u0) * s / w, v1 + (v0 - v1) * t / h]
            }
        }
    }
}

/// A mesh with one material and one lightmap square.
pub(super) struct Part {
    pub(super) name: &'static str,
    pub(super) material: usize,
    faces: Vec<Face>,
    charts: usize,
}

/// Vertex and index data, ready to be written.
#[derive(Default)]
pub(super) struct Geometry {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) uv0: Vec<[f32; 2]>,
    pub(super) uv1: Vec<[f32; 2]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Part {
    pub(super) fn new(name: &'static str, material: usize) -> Self {
        Self { name, material, faces: Vec::new(), charts: 0 }
    }

    /// Begins a chart: the faces that follow lie in it.
    pub(super) fn chart(&mut self) {
        self.charts += 1;
    }

    /// Adds a face to the current chart.
    pub(super) fn face(&mut self, corners: &[(P, [f64; 2])], uv: Uv) {
        let corners = corners
            .iter()
            .map(|&(position, chart)| Corner { position, chart, uv: uv.at(chart) })
            .collect();
        self.faces.push(Face { corners, chart: self.charts - 1 });
    }

    /// A strip chart: `profile` is carried along `stations` points of a path. `at(station, point)`
    /// places a profile point; seen from the front, stations run to the left of the profile's
    /// direction. `keep(segment, interval)` leaves faces out (doors).
    pub(super) fn sweep(
        &mut self,
        profile: &[[f64; 2]],
        stations: usize,
        uv: Uv,
        at: impl Fn(usize, [f64; 2]) -> P,
        keep: impl Fn(usize, usize) -> bool,
    ) {
        self.chart();
        // Chart coordinates: s along the path where it is longest, t along the profile.
        let mut t = vec![0.0];
        for pair in profile.windows(2) {
            t.push(t[t.len() - 1] + (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]));
        }
        let mut s = vec![0.0];
        for j in 1..stations {
            let step = profile.iter().map(|&p| distance(at(j - 1, p), at(j, p)));
            s.push(s[j - 1] + step.fold(0.0, f64::max));
        }
        for i in 0..profile.len() - 1 {
            for j in (0..stations - 1).filter(|&j| keep(i, j)) {
                let corner = |i: usize, j: usize| (at(j, profile[i]), [s[j], t[i]]);
                let quad = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                self.face(&quad, uv);
            }
        }
    }

    /// Normals, packed charts, triangles.
    pub(super) fn build(&self) -> Geometry {
        let layout = self.lay_out();
        let normals = self.normals();
        let mut geometry = Geometry::default();
        let mut known = HashMap::new();
        for (face, normals) in self.faces.iter().zip(normals) {
            let indices: Vec<u32> = face
                .corners
                .iter()
                .zip(normals)
                .map(|(corner, normal)| {
                    let uv1 = layout.uv(face.chart, corner.chart);
                    let vertex = (
                        corner.position.map(grid),
                        normal.map(|n| grid_f32(n, 4096.0)),
                        corner.uv.map(|v| grid_f32(v, 65536.0)),
                        uv1.map(|v| grid_f32(v, 65536.0)),
                    );
                    let bits = |v: &[f32]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                    let key = [&vertex.0[..], &vertex.1, &vertex.2, &vertex.3].map(bits);
                    *known.entry(key).or_insert_with(|| {
                        geometry.positions.push(vertex.0);
                        geometry.normals.push(normalize_f32(vertex.1));
                        geometry.uv0.push(vertex.2);
                        geometry.uv1.push(vertex.3);
                        geometry.positions.len() as u32 - 1
                    })
                })
                .collect();
            for k in 1..indices.len() - 1 {
                let triangle = [indices[0], indices[k], indices[k + 1]];
                // Quads at the poles of a ball have two corners in one place.
                let [a, b, c] = triangle.map(|i| geometry.positions[i as usize]);
                if a != b && b != c && c != a {
                    geometry.triangles.push(triangle);
                }
            }
        }
        geometry
    }

    /// Where the charts lie.
    pub(super) fn lay_out(&self) -> pack::Layout {
        let mut bounds = vec![[f64::MAX, f64::MAX, f64::MIN, f64::MIN]; self.charts];
        for face in &self.faces {
            let b = &mut bounds[face.chart];
            for [s, t] in face.corners.iter().map(|c| c.chart) {
                *b = [b[0].min(s), b[1].min(t), b[2].max(s), b[3].max(t)];
            }
        }
        pack::pack(&bounds, TEXELS_PER_METRE)
    }

    /// Corner normals: faces that meet at under 50 degrees are smoothed, weighted by their area, so
    /// that large faces stay flat and narrow bevels turn from one to the next.
    fn normals(&self) -> Vec<Vec<P>> {
        let area_normal = |face: &Face| {
            let c: Vec<P> = face.corners.iter().map(|c| c.position).collect();
            (1..c.len() - 1)
                .fold([0.0; 3], |sum, k| add(sum, cross(sub(c[k], c[0]), sub(c[k + 1], c[0]))))
        };
        let normals: Vec<P> = self.faces.iter().map(area_normal).collect();
        let key = |p: P| p.map(|v| (v * 8192.0).round() as i64);
        let mut around: HashMap<_, Vec<usize>> = HashMap::new();
        for (i, face) in self.faces.iter().enumerate() {
            for corner in &face.corners {
                around.entry(key(corner.position)).or_default().push(i);
            }
        }
        let limit = 50_f64.to_radians().cos();
        let corner_normal = |i: usize, corner: &Corner| {
            let own = normalize(normals[i]);
            let near = around[&key(corner.position)].iter().map(|&j| normals[j]);
            normalize(near.filter(|&n| dot(own, normalize(n)) > limit).fold([0.0; 3], add))
        };
        let faces = self.faces.iter().enumerate();
        faces.map(|(i, f)| f.corners.iter().map(|c| corner_normal(i, c)).collect()).collect()
    }
}

/// Coordinates are multiples of 1/8192 m: the last bits of a platform's sine do not matter.
fn grid(v: f64) -> f32 {
    grid_f32(v, 8192.0)
}

pub(super) fn grid_f32(v: f64, steps: f64) -> f32 {
    // The sum turns -0 into 0.
    ((v * steps).round() / steps + 0.0) as f32
}

fn normalize_f32(n: [f32; 3]) -> [f32; 3] {
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    n.map(|v| v / length)
}

pub(super) fn add(a: P, b: P) -> P {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn sub(a: P, b: P) -> P {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scale(a: P, s: f64) -> P {
    a.map(|v| v * s)
}

pub(super) fn dot(a: P, b: P) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: P, b: P) -> P {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn normalize(a: P) -> P {
    scale(a, 1.0 / dot(a, a).sqrt().max(1e-12))
}

pub(super) fn distance(a: P, b: P) -> f64 {
    let d = sub(a, b);
    dot(d, d).sqrt()
}
