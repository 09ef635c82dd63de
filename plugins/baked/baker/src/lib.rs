//! Baked lighting: from a glTF file to a lit one.
//!
//! The files and their meaning are those of [`farlight_baked_format`].
