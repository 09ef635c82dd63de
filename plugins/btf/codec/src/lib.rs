//! Measured materials: a *bidirectional texture function* (BTF) says for each texel, each direction
//! of light and each direction of view how bright and of what colour a surface is.
//!
//! This crate reads such materials, evaluates them on the CPU (the specification of the shaders)
//! and on the GPU, and compresses them. It knows no engine.
//!
//! # The compressed form
//!
//! A texel is a function of four numbers: azimuth and elevation of the view, and two angles of the
//! light round that view ([`SliceAngles`]). Each level of a chain of code-books replaces one number
//! by rows of the level below (Havran, Filip, Myszkowski, *Bidirectional Texture Function
//! Compression Based on Multi-Level Vector Quantization*, Computer Graphics Forum 29(1), 2010):
//!
//! | table of [`Tables`] | one row has | and leads to |
//! |---|---|---|
//! | `texels` | one entry a texel | a row of `azimuths`, with a scale |
//! | `azimuths` | one entry an azimuth of the view | a row of `elevations`, with a scale |
//! | `elevations` | one entry an elevation of the view | a slice, with a scale |
//! | `slices` | two entries | a row of `luminances` and a row of `chromas` |
//! | `luminances` | one entry an angle alpha of the light | a row of `shapes`, with a scale |
//! | `shapes` | one number an angle beta of the light | luminance |
//! | `chromas` | one entry an angle alpha | a row of `colour_rows` |
//! | `colour_rows` | one entry an angle beta | a colour |
//! | `colours` | two numbers | blue and red chroma (or u' and v') |
//!
//! [`Btf`] holds the tables packed into 32-bit words, as a file stores them and as the GPU reads
//! them; `slices` and `colours` are dissolved there in the tables that lead to them, which saves a
//! third of the look-ups.

mod albedo;
mod angles;
mod check;
mod colour;
pub mod compress;
mod error;
mod evaluate;
mod file;
#[cfg(feature = "gpu")]
pub mod gpu;
mod images;
mod info;
mod layout;
mod material;
mod pack;
pub mod read;
mod sample;
pub mod synthetic;
mod tables;
mod words;

pub use albedo::Albedo;
pub use angles::{Angles, Cell, SliceAngles};
pub use colour::{ColourSpace, linear, srgb_encode};
pub use error::BtfError;
pub use evaluate::{Backend, Query, Rules, ViewSlices};
pub use images::{ImageBtf, Picture, Resampled};
pub use info::{Certainty, Info, Repair, fade_slope};
pub use layout::{Coded, Layout, Packed};
pub use material::{Btf, TableSize};
pub use sample::{LightSample, LightSampler, ViewFrame};
pub use tables::{References, Samples, Scaled, Tables};
