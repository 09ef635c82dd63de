//! What measured materials are looked at on: a rabbit, a hippopotamus, cloth on a form.
//!
//! Metres, y up, facing +z, standing on y = 0. One metre of surface is one unit of the UV set, so that
//! cloth keeps its size on all of them.

mod animals;
mod drape;
mod mesh;
mod net;
mod panels;
mod solid;

use super::glb::{self, Look};

/// The models: file name and file.
pub(super) fn all() -> Vec<(&'static str, Vec<u8>)> {
    let toy = |name, [cloth, beads]: animals::Toy| {
        glb::write_surfaces(name, &[cloth.surface(Look::Btf), beads.surface(Look::Bead)])
    };
    vec![
        ("bunny.glb", toy("bunny", animals::bunny())),
        ("hippo.glb", toy("hippo", animals::hippo())),
        (
            "drape.glb",
            glb::write_surfaces(
                "drape",
                &[drape::drape().surface(Look::Btf), drape::form().surface(Look::Form)],
            ),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_small() {
        for (name, bytes) in all() {
            assert!(bytes.len() < 400_000, "{name}: {} bytes", bytes.len());
        }
    }

    /// Cloth is not stretched: lengths in the picture are those on the body.
    #[test]
    fn a_metre_of_surface_is_a_metre_of_cloth() {
        for (name, [cloth, _]) in [("bunny", animals::bunny()), ("hippo", animals::hippo())] {
            let mut stretch = panels::stretch(&cloth);
            stretch.sort_by(f64::total_cmp);
            let at = |share: f64| stretch[(share * stretch.len() as f64) as usize];
            let shares = [0.01, 0.05, 0.5, 0.95, 0.99].map(at);
            println!("{name}: {} triangles, stretch {shares:.3?}", cloth.triangles.len());
            assert!((shares[2] - 1.0).abs() < 0.02, "{name}: {shares:?}");
            assert!(shares[1] > 0.8 && shares[3] < 1.2, "{name}: {shares:?}");
            assert!((5_000..15_000).contains(&cloth.triangles.len()));
        }
    }

    /// Every triangle of cloth looks to the side that its normals say, and its picture is not mirrored.
    #[test]
    fn no_triangle_is_turned() {
        use crate::assets::part::{cross, dot, sub};
        for (name, mesh) in [("bunny", animals::bunny()[0].clone()), ("drape", drape::drape())] {
            let (mut turned, mut mirrored) = (0, 0);
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|i| mesh.positions[i]);
                let normal = cross(sub(b, a), sub(c, a));
                turned += usize::from(dot(normal, mesh.normals[t[0]]) < 0.0);
                let [p, q, r] = t.map(|i| mesh.uvs[i]);
                let area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
                // v runs down, so that counter-clockwise has a negative sign.
                mirrored += usize::from(area > 0.0);
            }
            let limit = mesh.triangles.len() / 200;
            assert!(turned <= limit && mirrored <= limit, "{name}: {turned}, {mirrored}");
        }
    }
}
