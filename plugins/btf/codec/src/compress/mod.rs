//! Compression by multi-level vector quantization.

mod grid;

pub use grid::Grid;
