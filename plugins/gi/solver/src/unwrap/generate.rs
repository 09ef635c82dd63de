//! New second UV sets.

use std::collections::HashMap;

use glam::{UVec2, Vec2, Vec3};
use uvunwrap::{Atlas, Density, MeshInput, Options, Packing};

use super::{UnwrapError, UnwrapOptions, Unwrapped, charts, charts::Sets};
use crate::scene::Mesh;

/// Largest square that is tried.
const MAX_PAGE: u32 = 4096;

/// Unwraps a valid mesh. The inner `None` is returned when `go_on` was false.
pub(super) fn generate(
    mesh: &Mesh,
    options: &UnwrapOptions,
    repack: bool,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Unwrapped, Option<UnwrapError>> {
    let (positions, extent) = normalized(mesh)?;
    let (seams, pieces) = seams(mesh, &positions, options);
    let repack = repack && mesh.uv1.len() == mesh.positions.len();
    let own: Vec<[f32; 2]> = mesh.uv1.iter().map(|uv| uv.to_array()).collect();
    let input = MeshInput {
        seams: (!repack).then_some(&seams),
        existing_uvs: repack.then_some(own.as_slice()),
        ..MeshInput::new(&positions, mesh.triangles.as_flattened())
    };
    let work = Work { input, options, go_on };
    let texels = options.texels.clamp(8, MAX_PAGE);
    let (atlas, page) = match options.density.map(|density| density * extent) {
        Some(density) => match work.at_density(mesh, density, extent, texels)? {
            Some(atlas) => (atlas, texels),
            None => work.one_page(pieces, texels)?,
        },
        None => work.one_page(pieces, texels)?,
    };
    let Some(out) = atlas.meshes.first() else {
        return Err(Some(UnwrapError::Failed("no result".into())));
    };
    // Pages are cropped to the rows in use.
    let mut size = UVec2::new(atlas.width, atlas.height).max(UVec2::ONE);
    let mut stretch = Vec2::ONE;
    if options.density.is_none() {
        // Back to a square.
        stretch = Vec2::new(1.0, size.y as f32 / size.x as f32).min(Vec2::ONE);
        size = UVec2::splat(texels);
    } else if page > texels {
        size = (size * texels / page).max(UVec2::ONE);
    }
    let mut unwrapped = Unwrapped {
        source: out.vertices.iter().map(|v| v.xref).collect(),
        triangles: out.indices.as_chunks::<3>().0.to_vec(),
        uv1: out.vertices.iter().map(|v| Vec2::from(v.uv) * stretch).collect(),
        gutter: (2 * work.padding()) as f32 * texels as f32 / page as f32,
        size,
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

struct Work<'a> {
    input: MeshInput<'a>,
    options: &'a UnwrapOptions,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Work<'_> {
    /// Texels around each chart.
    fn padding(&self) -> u32 {
        self.options.padding.div_ceil(2).clamp(1, 64)
    }

    /// One page of the size that the charts need; `None` if it is larger than `texels`.
    fn at_density(
        &self,
        mesh: &Mesh,
        density: f32,
        extent: f32,
        texels: u32,
    ) -> Result<Option<Atlas>, Option<UnwrapError>> {
        let corner = |i: u32| mesh.positions[i as usize].as_dvec3() / f64::from(extent);
        let area: f64 = mesh
            .triangles
            .iter()
            .map(|t| t.map(corner))
            .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
            .sum();
        let needed = area * f64::from(density).powi(2);
        let possible = density > 0.0 && needed <= f64::from(texels).powi(2);
        if !possible {
            return Ok(None);
        }
        let density = Density::Fixed { texels_per_unit: density, page_size: None };
        let atlas = self.run(density)?;
        Ok((atlas.width.max(atlas.height) <= texels).then_some(atlas))
    }

    /// The highest density that fits a page of `texels`, and the page that was necessary.
    fn one_page(&self, pieces: u32, texels: u32) -> Result<(Atlas, u32), Option<UnwrapError>> {
        // Too many charts for gutters of this width make finer texels necessary: a chart with its
        // gutters takes at least 3 x 3 of them.
        let edge = f64::from(2 * self.padding()) + 1.5;
        let needed = |charts: u32| {
            let needed = (edge * f64::from(charts).sqrt()) as u32;
            if needed > texels { needed.next_power_of_two() } else { 0 }
        };
        let mut page = texels.max(needed(pieces)).min(MAX_PAGE);
        loop {
            let atlas = self.run(Density::Auto { page_size: page })?;
            if atlas.page_count <= 1 {
                return Ok((atlas, page));
            }
            if page >= MAX_PAGE {
                return Err(Some(UnwrapError::TooManyCharts { charts: atlas.chart_count }));
            }
            page = (page * 2).max(needed(atlas.chart_count)).min(MAX_PAGE);
        }
    }

    fn run(&self, density: Density) -> Result<Atlas, Option<UnwrapError>> {
        let fast = self.input.indices.len() > 3 * 20_000;
        let options = Options {
            max_chart_angle: self.options.chart_angle.to_degrees().clamp(1.0, 89.0),
            max_area_distortion: self.options.distortion.max(1.0),
            density,
            padding: self.padding(),
            packing: if fast { Packing::Fast } else { Packing::Shape },
            ..Options::default()
        };
        uvunwrap::generate_with_progress(&[self.input], &options, |_| (self.go_on)()).map_err(
            |error| match error {
                uvunwrap::Error::Cancelled => None,
                other => Some(UnwrapError::Failed(other.to_string())),
            },
        )
    }
}

/// Positions in the unit cube: the unwrapper's tolerances need not know millimetres from miles.
/// Also the length of its edge.
fn normalized(mesh: &Mesh) -> Result<(Vec<[f32; 3]>, f32), UnwrapError> {
    let (low, high) = mesh
        .positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let extent = (high - low).max_element();
    if !(extent > 0.0 && extent.is_finite()) {
        return Err(UnwrapError::Failed(format!("its size is {extent}")));
    }
    // Adding 0 turns -0 into 0: vertices are welded by their bits.
    let positions = mesh.positions.iter().map(|&p| ((p - low) / extent + 0.0).to_array());
    Ok((positions.collect(), extent))
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
