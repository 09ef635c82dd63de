//! The lightmap solver: an answer in milliseconds, better ones until it converges.
//!
//! What is solved for is irradiance at the texels of the receivers' second UV squares, and radiance
//! at probes, without what punctual lights send there directly, and without what the sky does if the
//! scene leaves that out ([`DirectSky`](crate::scene::DirectSky)). The work is split so that light
//! that changes costs little:
//!
//! 1. *Texels* (`raster`): each receiver's second UV square is rasterized at its resolution; texels
//!    whose point lies inside of other geometry get one in the open (`bury`).
//! 2. *Patches* (`patches`): each side of a texel exchanges light; surfaces without a lightmap are
//!    cut into surfels when rays meet them.
//! 3. *Transport* (`transport`): rays from each patch are traced once and remembered by the patch
//!    that they met.
//! 4. *Direct light* (`direct`): four shadow rays a patch, only for lights that moved; a light whose
//!    intensity changed only scales.
//! 5. *Bounces and the last gather* (`lighting/solve`): sums over remembered rays, no tracing.
//! 6. *Refinement* (`lighting/refine`): while light is still, rays that are not kept and look closer.
//! 7. *Output* (`lighting/output`, `fill`): a filter that fades as noise does, and dilation of the
//!    texels around each chart.
//!
//! What it does not do: emissive surfaces are found by gather rays alone, so that small bright ones
//! are noisy (and then filtered) until many rays are traced; a sun inside of a sky image casts shadows
//! blurred by six degrees (a directional light does not).
//!
//! The idea of keeping the rays and re-lighting what they met is instant radiosity's final gather
//! turned into a table; compare Lehtinen et al. 2008, "A Meshless Hierarchical Representation for Light
//! Transport", and the surfel caches of current engines.

mod bake;
mod bury;
mod closed;
mod direct;
mod fill;
mod grids;
pub(crate) mod lighting;
mod patches;
mod raster;
mod sequence;
mod sky;
mod transport;

pub use bake::{Lightmap, LightmapSolver};
pub(crate) use bury::{is_hidden_back, unbury};
pub(crate) use closed::is_closed;
pub(crate) use fill::FillPlan;
pub(crate) use grids::GridState;
pub(crate) use lighting::{Lighting, Limits, luminance, median};
pub(crate) use patches::{Patches, Receiver};
pub(crate) use raster::{MeshTexels, NONE, SAMPLES, SurfacePoint, barycentric};
pub(crate) use transport::Buried;
