//! Files of baked lighting, without an engine and without a solver.
//!
//! | module | what |
//! |---|---|
//! | [`manifest`] | which primitive is lit by which rectangle of which page, in which scenario |
//! | [`fingerprint`] | short content hashes |
//! | [`ktx2`] | lightmap pages and irradiance volumes as textures |
//! | [`exr`] | lightmap pages as pictures |
//! | [`rgb9e5`] | texels of four bytes |
//! | [`volume`] | where an irradiance volume has its probes |
//! | [`name`] | file names |
//!
//! # Units
//! Lengths in metres; right-handed, y up; linear Rec. 709. A lightmap texel holds E / π, irradiance over
//! π, in cd/m² (lx/sr), as Bevy's lightmaps do.

pub mod exr;
pub mod fingerprint;
pub mod ktx2;
pub mod manifest;
pub mod name;
pub mod rgb9e5;
pub mod volume;

pub use fingerprint::Fingerprint;
pub use manifest::Manifest;
