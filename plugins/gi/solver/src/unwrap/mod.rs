//! Second UV sets for lightmaps: checked, or made.
//!
//! A lightmap needs a second UV set that is complete, lies in the unit square and covers no texel
//! twice. [`ensure_uv1`] keeps a set that does and makes one otherwise, with the crate `uvunwrap`.
//! Vertices at one place are joined, each sheet of the surface by itself; charts grow within a normal
//! cone and stop at hard edges, are flattened (least squares conformal maps, then as-rigid-as-possible),
//! and packed with gutters for the resolution that the mesh will get. Vertices on chart borders are split:
//! [`Unwrapped::source`] says where each came from, and triangles keep their order. [`density`],
//! [`gutter`] and [`coverage`] measure what came out.
//!
//! ```
//! use farlight_gi_solver::{scene::Mesh, unwrap::{UnwrapOptions, ensure_uv1}};
//! use glam::Vec3;
//!
//! let mesh = Mesh {
//!     positions: vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y],
//!     triangles: vec![[0, 1, 2], [0, 2, 3]],
//!     ..Default::default()
//! };
//! let unwrapped = ensure_uv1(&mesh, &UnwrapOptions { texels: 16, ..Default::default() })?;
//! assert!(unwrapped.made.is_some(), "there was no second UV set");
//! let mesh = unwrapped.apply(&mesh);
//! assert_eq!(mesh.uv1.len(), mesh.positions.len());
//! # Ok::<(), farlight_gi_solver::unwrap::UnwrapError>(())
//! ```

mod charts;
mod check;
mod generate;
mod measure;
mod raster;
mod surface;

use std::time::{Duration, Instant};

use glam::{UVec2, Vec2};
use thiserror::Error;

pub use charts::charts;
pub use check::{UvProblem, check_uv1};
pub use measure::{Density, coverage, density, gutter};

use crate::scene::{Mesh, MeshProblem};

/// How to check and make second UV sets.
#[derive(Clone, Debug)]
pub struct UnwrapOptions {
    /// Texels along an edge of the square that the mesh will get in a lightmap: charts are kept
    /// [`padding`](Self::padding) texels of this size apart, and half of that from the border, where
    /// they are few enough for that. With a [`density`](Self::density) the most texels along an edge.
    pub texels: u32,
    /// Texels a unit of length of the mesh. Then the charts fill a rectangle of the texels that they
    /// need ([`Unwrapped::size`]); if an edge would be longer than [`texels`](Self::texels), the density
    /// is as large as possible.
    pub density: Option<f32>,
    /// Texels between charts: bilinear lookups need 2, each mip level doubles that. Rounded up to an even
    /// number.
    pub padding: u32,
    /// Largest ratio of a triangle's share of its chart's texels to its share of the chart's surface,
    /// either way, above 1. Charts that exceed it are split.
    pub distortion: f32,
    /// Edges whose faces meet at a larger angle (radians) are always chart borders.
    pub hard_angle: f32,
    /// So are edges at which the shading normals are split and the faces meet at a larger angle than
    /// this (radians).
    pub split_angle: f32,
    /// Largest angle (radians, below π/2) between a face and its chart's average normal.
    pub chart_angle: f32,
    /// Pack charts of large meshes by their shapes too: a tenth more texels a metre, in several times the
    /// time.
    pub thorough: bool,
    /// Refuse to unwrap meshes with more triangles: it takes about 80 µs and 1 kB a triangle, twice
    /// that for small ones, which are unwrapped in two ways, of which the better is taken.
    pub max_triangles: usize,
    /// Give up after this time.
    pub max_time: Duration,
}

impl Default for UnwrapOptions {
    fn default() -> Self {
        Self {
            texels: 64,
            density: None,
            padding: 2,
            distortion: 4.0,
            hard_angle: 60_f32.to_radians(),
            split_angle: 35_f32.to_radians(),
            chart_angle: 60_f32.to_radians(),
            thorough: false,
            max_triangles: 1_000_000,
            max_time: Duration::from_secs(120),
        }
    }
}

/// Why there is no second UV set.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum UnwrapError {
    /// The mesh itself is not usable.
    #[error(transparent)]
    Mesh(#[from] MeshProblem),
    /// Unwrapping would take too long.
    #[error(
        "the mesh has {triangles} triangles, automatic unwrapping stops at {limit}: split it, give \
         it a second UV set in your modelling program, or raise UnwrapOptions::max_triangles"
    )]
    TooManyTriangles {
        /// How many there are.
        triangles: usize,
        /// How many may be.
        limit: usize,
    },
    /// [`UnwrapOptions::max_time`] passed.
    #[error(
        "automatic unwrapping took longer than {seconds} s: split the mesh, give it a second UV set \
         in your modelling program, or raise UnwrapOptions::max_time"
    )]
    TooSlow {
        /// The limit.
        seconds: f32,
    },
    /// The caller asked to stop.
    #[error("unwrapping was cancelled")]
    Cancelled,
    /// The charts do not fit a square of 4096 texels.
    #[error("the mesh falls into {charts} charts, too many for one lightmap: split it")]
    TooManyCharts {
        /// How many there are.
        charts: u32,
    },
    /// The unwrapper failed.
    #[error("the mesh cannot be unwrapped: {0}")]
    Failed(String),
}

/// A mesh's second UV set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unwrapped {
    /// For each new vertex the vertex of the mesh that it was made from.
    pub source: Vec<u32>,
    /// Vertex indices, one triple a triangle of the mesh, in its order.
    pub triangles: Vec<[u32; 3]>,
    /// Second UV set, one a new vertex, in 0..1, `v = 0` at the first row.
    pub uv1: Vec<Vec2>,
    /// Chart of each triangle ([`charts`]).
    pub charts: Vec<u32>,
    /// Why the mesh's own set was not kept; `None` if it was.
    pub made: Option<UvProblem>,
    /// Texels ([`UnwrapOptions::texels`]) between neighbouring charts: the padding that was asked for,
    /// unless there are so many charts that the gutters had to shrink. Not measured (infinite) for a set
    /// that was kept.
    pub gutter: f32,
    /// Edges in texels of what the square 0..1 should get. Zero for a set that was kept.
    pub size: UVec2,
}

impl Unwrapped {
    /// The mesh with the new vertices.
    #[must_use]
    pub fn apply(&self, mesh: &Mesh) -> Mesh {
        fn pick<T: Copy>(values: &[T], source: &[u32]) -> Vec<T> {
            if values.is_empty() {
                return Vec::new();
            }
            source.iter().map(|&i| values[i as usize]).collect()
        }
        Mesh {
            positions: pick(&mesh.positions, &self.source),
            normals: pick(&mesh.normals, &self.source),
            uv0: pick(&mesh.uv0, &self.source),
            uv1: self.uv1.clone(),
            triangles: self.triangles.clone(),
        }
    }
}

/// Makes a second UV set, whatever the mesh has. With `repack` the charts of its own set are kept where
/// they are usable, and only scaled to even density and packed anew.
///
/// # Errors
/// As [`ensure_uv1_with`].
pub fn make_uv1(
    mesh: &Mesh,
    options: &UnwrapOptions,
    repack: bool,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Unwrapped, UnwrapError> {
    mesh.validate()?;
    let clock = Clock::start(options, go_on);
    let triangles = mesh.triangles.len();
    let limit = options.max_triangles;
    if triangles > limit {
        return Err(UnwrapError::TooManyTriangles { triangles, limit });
    }
    generate::generate(mesh, options, repack, &|| clock.go_on())
        .map_err(|error| error.unwrap_or_else(|| clock.stopped()))
}

/// Until when to work.
struct Clock<'a> {
    start: Instant,
    limit: Duration,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Clock<'a> {
    fn start(options: &UnwrapOptions, go_on: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self { start: Instant::now(), limit: options.max_time, go_on }
    }

    fn in_time(&self) -> bool {
        self.start.elapsed() < self.limit
    }

    fn go_on(&self) -> bool {
        (self.go_on)() && self.in_time()
    }

    /// Why it was stopped.
    fn stopped(&self) -> UnwrapError {
        match self.in_time() {
            true => UnwrapError::Cancelled,
            false => UnwrapError::TooSlow { seconds: self.limit.as_secs_f32() },
        }
    }
}

/// Checks a mesh's second UV set and makes one if it cannot be used.
///
/// # Errors
/// [`UnwrapError`] if the mesh is not valid or too large to be unwrapped.
pub fn ensure_uv1(mesh: &Mesh, options: &UnwrapOptions) -> Result<Unwrapped, UnwrapError> {
    ensure_uv1_with(mesh, options, &|| true)
}

/// [`ensure_uv1`] for a thread that somebody may want to stop: `go_on` is asked often and from any
/// thread.
///
/// # Errors
/// As [`ensure_uv1`], and [`UnwrapError::Cancelled`] after `go_on` returned `false`.
pub fn ensure_uv1_with(
    mesh: &Mesh,
    options: &UnwrapOptions,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Unwrapped, UnwrapError> {
    mesh.validate()?;
    let clock = Clock::start(options, go_on);
    let problem = check::check_while(mesh, check::RESOLUTION, &|| clock.go_on());
    match problem.ok_or_else(|| clock.stopped())? {
        None => Ok(Unwrapped {
            source: (0..mesh.positions.len() as u32).collect(),
            triangles: mesh.triangles.clone(),
            uv1: mesh.uv1.clone(),
            charts: charts(mesh),
            made: None,
            gutter: f32::INFINITY,
            size: UVec2::ZERO,
        }),
        Some(problem) => {
            let mut unwrapped = make_uv1(mesh, options, false, go_on)?;
            unwrapped.made = Some(problem);
            Ok(unwrapped)
        }
    }
}
