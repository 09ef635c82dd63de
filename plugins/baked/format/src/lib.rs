//! Files of baked lighting, without an engine and without a solver.
//!
//! | module | what |
//! |---|---|
//! | [`manifest`] | which primitive is lit by which rectangle of which page, in which scenario |
//! | [`fingerprint`] | short content hashes |
//!
//! # Units
//! Lengths in metres; right-handed, y up; linear Rec. 709. A lightmap texel holds E / π, irradiance over
//! π, in cd/m² (lx/sr), as Bevy's lightmaps do.

pub mod fingerprint;
pub mod manifest;

pub use fingerprint::Fingerprint;
pub use manifest::Manifest;
