//! Triangles with what a measured material needs: normals, UVs in metres, tangents.

use crate::assets::{
    glb::{Look, Surface},
    part::{P, add, cross, dot, grid_f32, normalize, scale, sub},
};

/// A mesh in metres; UVs in metres too, v down.
#[derive(Clone, Default)]
pub(super) struct Mesh {
    pub(super) positions: Vec<P>,
    pub(super) normals: Vec<P>,
    pub(super) uvs: Vec<[f64; 2]>,
    pub(super) tangents: Vec<P>,
    pub(super) triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// Tangents along growing u, a mean over the triangles round each vertex.
    pub(super) fn tangents_from_uvs(&mut self) {
        let mut sums = vec![[0.0; 3]; self.positions.len()];
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| self.positions[i]);
            let [ua, ub, uc] = t.map(|i| self.uvs[i]);
            let (e, f) = (sub(b, a), sub(c, a));
            let (du, dv) = ([ub[0] - ua[0], uc[0] - ua[0]], [ub[1] - ua[1], uc[1] - ua[1]]);
            let area = du[0] * dv[1] - du[1] * dv[0];
            // The sign of the area, the size left out: large triangles count more.
            let along = scale(sub(scale(e, dv[1]), scale(f, dv[0])), area.signum());
            for &i in t {
                sums[i] = add(sums[i], along);
            }
        }
        self.tangents = sums
            .iter()
            .zip(&self.normals)
            .map(|(&sum, &n)| normalize(sub(sum, scale(n, dot(n, sum)))))
            .collect();
    }

    /// Normals from the triangles, weighted by their area.
    pub(super) fn normals_from_triangles(&mut self) {
        let mut sums = vec![[0.0; 3]; self.positions.len()];
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| self.positions[i]);
            let normal = cross(sub(b, a), sub(c, a));
            for &i in t {
                sums[i] = add(sums[i], normal);
            }
        }
        self.normals = sums.into_iter().map(normalize).collect();
    }

    /// Makes it `factor` times as large, UVs too.
    pub(super) fn scale(mut self, factor: f64) -> Self {
        self.positions.iter_mut().for_each(|p| *p = scale(*p, factor));
        self.uvs.iter_mut().for_each(|uv| *uv = uv.map(|v| v * factor));
        self
    }

    /// Appends another mesh.
    pub(super) fn join(&mut self, other: Self) {
        let first = self.positions.len();
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uvs.extend(other.uvs);
        self.tangents.extend(other.tangents);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| first + i)));
    }

    /// Rounded, so that the last bits of a platform's arithmetic do not matter, and as a file holds it.
    pub(super) fn surface(&self, look: Look) -> Surface {
        let round = |v: P, steps: f64| v.map(|v| grid_f32(v, steps));
        Surface {
            look,
            positions: self.positions.iter().map(|&p| round(p, 65536.0)).collect(),
            normals: self.normals.iter().map(|&n| round(n, 4096.0)).collect(),
            uvs: self.uvs.iter().map(|uv| uv.map(|v| grid_f32(v, 65536.0))).collect(),
            tangents: self
                .tangents
                .iter()
                .map(|&t| {
                    let [x, y, z] = round(t, 4096.0);
                    [x, y, z, 1.0]
                })
                .collect(),
            triangles: self.triangles.iter().map(|t| t.map(|i| i as u32)).collect(),
        }
    }
}
