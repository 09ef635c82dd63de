//! New second UV sets.

use std::collections::HashMap;

use glam::{UVec2, Vec2, Vec3};
use uvunwrap::{Atlas, Density, MeshInput, Options, Packing};

use super::{UnwrapError, UnwrapOptions, Unwrapped, charts, surface::Surface};
use crate::scene::Mesh;

/// Meshes with more triangles are unwrapped in one way only, and packed in the faster one of two ways.
const LARGE: usize = 20_000;
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
    let surface = Surface::new(mesh, &positions, options);
    let pieces = surface.pieces;
    let repack = repack && mesh.uv1.len() == mesh.positions.len();
    let own: Vec<[f32; 2]> = mesh.uv1.iter().map(|uv| uv.to_array()).collect();
    let seams = Some(surface.seams.as_slice());
    let joined = MeshInput { seams, ..MeshInput::new(&surface.positions, &surface.corners) };
    // Vertices that are split (for textures, for flat faces) are seams here.
    let split = MeshInput { seams, ..MeshInput::new(&positions, mesh.triangles.as_flattened()) };
    let inputs = if repack {
        // Charts are as the set says, with the vertices that it has.
        vec![MeshInput { seams: None, existing_uvs: Some(own.as_slice()), ..split }]
    } else if mesh.triangles.len() > LARGE || positions.len() == surface.positions.len() {
        vec![joined]
    } else {
        vec![joined, split]
    };
    let work = Work { inputs, options, go_on };
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
        gutter: (2 * work.padding()) as f32 * texels as f32 / page as f32,
        size,
        ..Default::default()
    };
    // A vertex of the mesh for each place in the square that it has.
    let mut made = HashMap::with_capacity(out.vertices.len());
    let corners = mesh.triangles.as_flattened().iter().zip(&out.indices);
    let indices: Vec<u32> = corners
        .map(|(&vertex, &corner)| {
            *made.entry((vertex, corner)).or_insert_with(|| {
                unwrapped.source.push(vertex);
                let uv = out.vertices.get(corner as usize).map_or([0.0; 2], |v| v.uv);
                unwrapped.uv1.push(Vec2::from(uv) * stretch);
                unwrapped.source.len() as u32 - 1
            })
        })
        .collect();
    unwrapped.triangles = indices.as_chunks::<3>().0.to_vec();
    unwrapped.charts = charts(&Mesh {
        positions: unwrapped.source.iter().map(|&i| mesh.positions[i as usize]).collect(),
        uv1: unwrapped.uv1.clone(),
        triangles: unwrapped.triangles.clone(),
        ..Default::default()
    });
    Ok(unwrapped)
}

struct Work<'a> {
    /// What may be unwrapped: the best is taken.
    inputs: Vec<MeshInput<'a>>,
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

    /// The result that needs the fewest texels, the first unless another is clearly better.
    fn run(&self, density: Density) -> Result<Atlas, Option<UnwrapError>> {
        let mut best: Option<(f64, Atlas)> = None;
        for input in &self.inputs {
            let atlas = self.run_one(input, density)?;
            let texels = match density {
                Density::Fixed { .. } => f64::from(atlas.width) * f64::from(atlas.height),
                _ => f64::from(atlas.page_count) / f64::from(atlas.texels_per_unit).powi(2),
            };
            if best.as_ref().is_none_or(|(least, _)| texels < 0.97 * least) {
                best = Some((texels, atlas));
            }
        }
        best.map(|(_, atlas)| atlas).ok_or(None)
    }

    fn run_one(
        &self,
        input: &MeshInput<'_>,
        density: Density,
    ) -> Result<Atlas, Option<UnwrapError>> {
        let fast = input.indices.len() > 3 * LARGE && !self.options.thorough;
        let options = Options {
            max_chart_angle: self.options.chart_angle.to_degrees().clamp(1.0, 89.0),
            max_area_distortion: self.options.distortion.max(1.0),
            density,
            padding: self.padding(),
            packing: if fast { Packing::Fast } else { Packing::Shape },
            ..Options::default()
        };
        uvunwrap::generate_with_progress(&[*input], &options, |_| (self.go_on)()).map_err(|error| {
            match error {
                uvunwrap::Error::Cancelled => None,
                other => Some(UnwrapError::Failed(other.to_string())),
            }
        })
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
