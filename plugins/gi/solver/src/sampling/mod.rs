//! Random and low-discrepancy numbers, and maps from the unit square to directions.
//!
//! Everything is a pure function of a seed and an index, so results do not depend on how work is
//! spread over threads.
//!
//! - [`Rng`]: independent numbers (PCG32).
//! - [`PathSampler`]: the numbers of one path: Owen-scrambled Sobol points for its first
//!   directions, independent numbers for the rest.
//! - [`cosine_hemisphere`], [`uniform_sphere`], [`Frame`]: from numbers to directions.

mod map;
mod path_sampler;
mod rng;
mod sobol;

pub use map::{Frame, concentric_disk, cosine_hemisphere, uniform_sphere};
pub use path_sampler::PathSampler;
pub use rng::{Rng, hash, hash_pair, to_unit};
pub use sobol::{owen_scramble, sobol_4d, sobol_owen_4d};
