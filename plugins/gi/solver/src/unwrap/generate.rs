//! New second UV sets.

use std::collections::HashMap;

use glam::{Vec2, Vec3};
use uvunwrap::{Atlas, Density, MeshInput, Options, Packing};

use super::{UnwrapError, UnwrapOptions, Unwrapped, charts, charts::Sets};
use crate::scene::Mesh;

/// Largest square that is tried.
const MAX_PAGE: u32 = 4096;

/// Unwraps a valid mesh. The inner `None` is returned when `go_on` was false.
pub(super) fn generate(
    mesh: &Mesh,
    options: &UnwrapOptions,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Unwrapped, Option<UnwrapError>> {
    let positions = normalized(mesh)?;
    let (seams, pieces) = seams(mesh, &positions, options);
    let input = MeshInput {
        seams: Some(&seams),
        ..MeshInput::new(&positions, mesh.triangles.as_flattened())
    };
    let texels = options.texels.clamp(8, MAX_PAGE);
    // Too many charts for gutters of this width make finer texels necessary: a chart with its
    // gutters takes at least 3 x 3 of them.
    let needed = |charts: u32| {
        let texels = (3.5 * f64::from(charts).sqrt()) as u32;
        if texels > options.texels { texels.next_power_of_two() } else { 0 }
    };
    let mut page = texels.max(needed(pieces)).min(MAX_PAGE);
    let atlas = loop {
        let atlas = unwrap(&input, options, page, go_on)?;
        if atlas.page_count <= 1 {
            break atlas;
        }
        if page >= MAX_PAGE {
            return Err(Some(UnwrapError::TooManyCharts { charts: atlas.chart_count }));
        }
        page = (page * 2).max(needed(atlas.chart_count)).min(MAX_PAGE);
    };
    let Some(out) = atlas.meshes.first() else {
        return Err(Some(UnwrapError::Failed("no result".into())));
    };
    // Pages are cropped to the rows in use; back to a square.
    let stretch = Vec2::new(1.0, atlas.height as f32 / atlas.width.max(1) as f32).min(Vec2::ONE);
    let mut unwrapped = Unwrapped {
        source: out.vertices.iter().map(|v| v.xref).collect(),
        triangles: out.indices.as_chunks::<3>().0.to_vec(),
        uv1: out.vertices.iter().map(|v| Vec2::from(v.uv) * stretch).collect(),
        gutter: 2.0 * texels as f32 / page as f32,
        ..Default::default()
    };
    unwrapped.charts = charts(&Mesh {
        positions: unwrapped.source.iter().map(|&i| mesh.positions[i as usize]).collect(),
        uv1: unwrapped.uv1.clone(),
        triangles: unwrapped.triangles.clone(),
        ..Default::default()
    });
    Ok(unwrapped)
}

fn unwrap(
    input: &MeshInput<'_>,
    options: &UnwrapOptions,
    page: u32,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Atlas, Option<UnwrapError>> {
    let fast = input.indices.len() > 3 * 20_000;
    let options = Options {
        max_chart_angle: options.chart_angle.to_degrees().clamp(1.0, 89.0),
        density: Density::Auto { page_size: page },
        padding: 1,
        packing: if fast { Packing::Fast } else { Packing::Shape },
        ..Options::default()
    };
    uvunwrap::generate_with_progress(&[*input], &options, |_| go_on()).map_err(
        |error| match error {
            uvunwrap::Error::Cancelled => None,
            other => Some(UnwrapError::Failed(other.to_string())),
        },
    )
}

/// Positions in the unit cube: the unwrapper's tolerances need not know millimetres from miles.
fn normalized(mesh: &Mesh) -> Result<Vec<[f32; 3]>, UnwrapError> {
    let (low, high) = mesh
        .positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let extent = (high - low).max_element();
    if !(extent > 0.0 && extent.is_finite()) {
        return Err(UnwrapError::Failed(format!("its size is {extent}")));
    }
    // Adding 0 turns -0 into 0: vertices are welded by their bits.
    Ok(mesh.positions.iter().map(|&p| ((p - low) / extent + 0.0).to_array()).collect())
}

/// The edges that charts must not cross: sharp ones, those where smooth shading ends, and those of
/// more than two faces. Also the number of pieces into which they cut the surface.
fn seams(mesh: &Mesh, positions: &[[f32; 3]], options: &UnwrapOptions) -> (Vec<[bool; 3]>, u32) {
    let mut ids = HashMap::with_capacity(positions.len());
    let welded: Vec<u32> = positions
        .iter()
        .map(|p| {
            let next = ids.len() as u32;
            *ids.entry(p.map(f32::to_bits)).or_insert(next)
        })
        .collect();
    let normals: Vec<Vec3> = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| Vec3::from(positions[i as usize]));
            (b - a).cross(c - a).normalize_or_zero()
        })
        .collect();
    let (hard, split) = (options.hard_angle.cos(), options.split_angle.cos());
    let mut seams = vec![[false; 3]; mesh.triangles.len()];
    let mut sets = Sets::new(mesh.triangles.len());
    // The first face at an edge, and how many there are.
    let mut edges: HashMap<[u32; 2], (u32, u8, u32)> =
        HashMap::with_capacity(mesh.triangles.len() * 2);
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let ends = [triangle[k], triangle[(k + 1) % 3]];
            let [a, b] = ends.map(|i| welded[i as usize]);
            let entry = edges.entry([a.min(b), a.max(b)]).or_insert((t as u32, k as u8, 0));
            entry.2 += 1;
            let (first, first_k, faces) = *entry;
            if faces == 1 {
                continue;
            }
            let cos = normals[t].dot(normals[first as usize]);
            // A face without an area has no angle.
            let flat = normals[t] == Vec3::ZERO || normals[first as usize] == Vec3::ZERO;
            let sharp = cos < hard || (cos < split && normals_differ(mesh, t, k, first, first_k));
            if faces > 2 || (sharp && !flat) {
                seams[t][k] = true;
                seams[first as usize][first_k as usize] = true;
            } else {
                sets.join(first, t as u32);
            }
        }
    }
    (seams, sets.count())
}

/// Whether shading normals at an edge's ends depend on the face.
fn normals_differ(mesh: &Mesh, t: usize, k: usize, other: u32, other_k: u8) -> bool {
    if mesh.normals.is_empty() {
        // Then shading is flat.
        return true;
    }
    let ends = |t: usize, k: usize| {
        let triangle = mesh.triangles[t];
        [triangle[k], triangle[(k + 1) % 3]]
    };
    let ([a, b], [c, d]) = (ends(t, k), ends(other as usize, other_k as usize));
    // Neighbours usually run along their common edge in opposite directions.
    let same_place = mesh.positions[a as usize] == mesh.positions[c as usize];
    let (c, d) = if same_place { (c, d) } else { (d, c) };
    let differ = |i: u32, j: u32| {
        let [n, m] = [i, j].map(|i| mesh.normals[i as usize].normalize_or_zero());
        i != j && n.dot(m) < 0.97
    };
    differ(a, c) || differ(b, d)
}
