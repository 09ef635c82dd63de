//! Baking: lightmaps for files instead of frames.
//!
//! A [`Session`](crate::session::Session) answers in milliseconds and never stops to change; a bake has
//! minutes and no second chance. So it is made of other parts:
//!
//! 1. [`Layout`]: where the receivers lie on the pages, and the surface point behind every texel.
//! 2. [`Gatherer`]: passes of gather rays for every texel, summed in [`Gathered`], which can be saved
//!    and taken up again.
//! 3. [`direct`]: what arrives straight from lights, the mean over each texel's area.
//! 4. [`denoise`]: takes the noise out of what was gathered.
//! 5. [`pages`]: the texels on their pages, dilated.
//! 6. [`volume`]: probes on a grid, from the same light.
//!
//! Equal inputs give equal results on any number of threads.

mod cells;
mod denoise;
mod direct;
mod field;
mod gather;
mod layout;
mod links;
mod lobe;
mod map;
mod normals;
mod open;
mod pages;
mod saved;
mod sources;
mod uneven;
mod volume;

pub use denoise::denoise;
pub use direct::{DirectLight, direct};
pub use gather::{Gathered, Gatherer, GathererSettings};
pub use layout::{Density, Layout, LayoutSettings, LayoutTexel};
pub use pages::pages;
pub use saved::SavedError;
pub use volume::volume;
