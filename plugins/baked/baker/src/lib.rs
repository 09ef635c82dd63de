//! Baked lighting: from a glTF file to a lit one.
//!
//! | module | what |
//! |---|---|
//! | [`gltf`] | the file that is read, and the lit scene that is written |
//! | [`uv`] | which primitive gets which second UV set, and how many texels |
//!
//! The files and their meaning are those of [`farlight_baked_format`].

pub mod gltf;
pub mod uv;
