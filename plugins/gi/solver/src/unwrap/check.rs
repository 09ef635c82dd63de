//! Whether a second UV set can hold a lightmap.

use glam::{Vec2, Vec3};
use thiserror::Error;

use super::raster::covered;
use crate::scene::Mesh;

/// Texels along an edge of the square that is searched for overlaps.
pub(super) const RESOLUTION: u32 = 1024;

/// What is wrong with a second UV set.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum UvProblem {
    /// There is none.
    #[error("there is no second UV set")]
    Missing,
    /// It has not one value a vertex.
    #[error("the second UV set has {found} values for {vertices} vertices")]
    Length {
        /// How many values.
        found: usize,
        /// How many vertices.
        vertices: usize,
    },
    /// NaN or infinity.
    #[error("the second UV set holds values that are not finite (vertex {vertex})")]
    NotFinite {
        /// The first such vertex.
        vertex: usize,
    },
    /// It leaves the unit square: it tiles.
    #[error("the second UV set leaves the unit square: it reaches from {low} to {high}")]
    Outside {
        /// Smallest u and v.
        low: Vec2,
        /// Largest u and v.
        high: Vec2,
    },
    /// Parts of the surface have no area in the square.
    #[error("{percent:.1} % of the surface have no area in the second UV set")]
    Collapsed {
        /// How much of the surface.
        percent: f32,
    },
    /// Two places of the surface share texels.
    #[error("the second UV set overlaps itself in at least {percent:.2} % of what it covers")]
    Overlapping {
        /// How much of the covered part is covered twice; counting stops early.
        percent: f32,
    },
}

/// Checks a second UV set: one value a vertex, finite, inside of the unit square, no part without an
/// area, nothing covered twice (at the centres of `resolution` x `resolution` texels; triangles are
/// taken smaller by a hundredth of a texel, so shared edges do not count).
///
/// # Errors
/// The first [`UvProblem`] found.
pub fn check_uv1(mesh: &Mesh, resolution: u32) -> Result<(), UvProblem> {
    check_while(mesh, resolution, &|| true).flatten().map_or(Ok(()), Err)
}

/// `None` if `go_on` returned false, `Some(None)` if nothing is wrong.
pub(super) fn check_while(
    mesh: &Mesh,
    resolution: u32,
    go_on: &dyn Fn() -> bool,
) -> Option<Option<UvProblem>> {
    let (found, vertices) = (mesh.uv1.len(), mesh.positions.len());
    if found == 0 {
        return Some(Some(UvProblem::Missing));
    }
    if found != vertices {
        return Some(Some(UvProblem::Length { found, vertices }));
    }
    if let Some(vertex) = mesh.uv1.iter().position(|uv| !uv.is_finite()) {
        return Some(Some(UvProblem::NotFinite { vertex }));
    }
    // Vertices without triangles do not matter.
    let used = mesh.triangles.as_flattened().iter().filter_map(|&i| mesh.uv1.get(i as usize));
    let (low, high) = used
        .fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), &uv| (low.min(uv), high.max(uv)));
    // Half a texel of the finest lightmaps: rounding of exporters.
    let tolerance = 0.5 / 4096.0;
    if low.min_element() < -tolerance || high.max_element() > 1.0 + tolerance {
        return Some(Some(UvProblem::Outside { low, high }));
    }
    if let Some(percent) = collapsed(mesh) {
        return Some(Some(UvProblem::Collapsed { percent }));
    }
    overlap(mesh, resolution, go_on).map(|p| p.map(|percent| UvProblem::Overlapping { percent }))
}

/// Percent of the surface without an area in the square, if that matters.
fn collapsed(mesh: &Mesh) -> Option<f32> {
    let (mut whole, mut lost) = (0.0_f64, 0.0_f64);
    for triangle in &mesh.triangles {
        let [a, b, c] =
            triangle.map(|i| mesh.positions.get(i as usize).copied().unwrap_or(Vec3::ZERO));
        let area = f64::from((b - a).cross(c - a).length());
        if !area.is_finite() {
            continue;
        }
        whole += area;
        let [a, b, c] = triangle.map(|i| mesh.uv1.get(i as usize).copied().unwrap_or(Vec2::ZERO));
        if (b - a).as_dvec2().perp_dot((c - a).as_dvec2()) == 0.0 {
            lost += area;
        }
    }
    let percent = (lost / whole.max(f64::MIN_POSITIVE) * 100.0) as f32;
    (percent > 0.5).then_some(percent)
}

/// Percent of the covered texels that are covered twice, if that matters; `None` if stopped.
fn overlap(mesh: &Mesh, resolution: u32, go_on: &dyn Fn() -> bool) -> Option<Option<f32>> {
    let resolution = resolution.clamp(1, 8192);
    let mut taken = vec![false; resolution as usize * resolution as usize];
    let (mut once, mut twice) = (0_u64, 0_u64);
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        if t % 4096 == 0 && !go_on() {
            return None;
        }
        let corners = triangle.map(|i| mesh.uv1.get(i as usize).copied().unwrap_or(Vec2::ZERO));
        covered(corners, resolution, 0.01, |x, y| {
            let texel = &mut taken[(y * resolution + x) as usize];
            if *texel {
                twice += 1;
            } else {
                once += 1;
            }
            *texel = true;
        });
        // Thousands of triangles over the whole square would take long, and the answer is known.
        if twice > taken.len() as u64 {
            break;
        }
    }
    // A few texels come from rounding where charts are cut by curves.
    let matters = twice > 4 && twice as f64 > 1e-4 * once as f64;
    Some(matters.then(|| (twice as f64 / once.max(1) as f64 * 100.0) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two quads; the second is placed at `offset` in the square.
    fn quads(offset: [f32; 2]) -> Mesh {
        let square = [[0.0, 0.0], [0.4, 0.0], [0.4, 0.4], [0.0, 0.4]].map(Vec2::from);
        let shift = |by: Vec2| square.map(|uv| uv + by);
        let place = |z: f32| square.map(|uv| (uv * 10.0).extend(z));
        Mesh {
            positions: [place(0.0), place(1.0)].concat(),
            uv1: [shift(Vec2::splat(0.05)), shift(Vec2::from(offset))].concat(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..Default::default()
        }
    }

    #[test]
    fn sets_that_can_be_used_pass() {
        assert_eq!(check_uv1(&quads([0.55, 0.05]), 256), Ok(()));
        // Edge to edge is allowed.
        assert_eq!(check_uv1(&quads([0.45, 0.05]), 256), Ok(()));
    }

    #[test]
    fn each_problem_is_named() {
        let problem = |mesh: &Mesh| check_uv1(mesh, 256).unwrap_err();
        let mut mesh = quads([0.55, 0.05]);
        mesh.uv1[3].y = f32::NAN;
        assert_eq!(problem(&mesh), UvProblem::NotFinite { vertex: 3 });
        mesh.uv1.pop();
        assert_eq!(problem(&mesh), UvProblem::Length { found: 7, vertices: 8 });
        mesh.uv1.clear();
        assert_eq!(problem(&mesh), UvProblem::Missing);
        assert!(matches!(problem(&quads([0.8, 0.0])), UvProblem::Outside { .. }));
        let UvProblem::Overlapping { percent } = problem(&quads([0.25, 0.05])) else { panic!() };
        // Half of the second quad lies on the first: a third of what is covered.
        assert!((percent - 33.3).abs() < 3.0, "{percent}");
        let mut mesh = quads([0.55, 0.05]);
        mesh.uv1[4..].fill(Vec2::splat(0.7));
        assert_eq!(problem(&mesh), UvProblem::Collapsed { percent: 50.0 });
    }

    #[test]
    fn a_mountain_of_triangles_over_the_whole_square_ends_soon() {
        let mut mesh = quads([0.55, 0.05]);
        mesh.uv1[..3].copy_from_slice(&[Vec2::ZERO, Vec2::X, Vec2::ONE]);
        mesh.triangles = vec![[0, 1, 2]; 500_000];
        assert!(matches!(check_uv1(&mesh, 1024), Err(UvProblem::Overlapping { .. })));
    }
}
