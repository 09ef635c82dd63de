//! Readers of material files.

mod text;

pub use text::read_text;
