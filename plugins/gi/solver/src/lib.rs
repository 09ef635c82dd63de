//! Global illumination for static and dynamic receivers, without an engine.
//!
//! The crate takes a [`Scene`] (meshes, instances, materials, lights, sky) and answers what a
//! renderer without ray tracing cannot: indirect irradiance per lightmap texel, radiance probes in
//! spherical harmonics, and the same quantities at arbitrary receivers.
//!
//! | module | what |
//! |---|---|
//! | [`scene`] | what light travels through: stable ids, shared meshes and textures, changes |
//! | [`import`] | glTF files into scenes, with limits and clear errors |
//! | [`tracer`] | batches of closest-hit and any-hit rays over an 8-wide BVH |
//! | [`world`] | a scene flattened for tracing: surfaces at hits |
//! | [`sampling`], [`sh`] | random and low-discrepancy numbers; spherical harmonics |
//! | [`visibility`] | rays against cut-out materials, robust origins, what lights are seen |
//! | [`path`] | the path tracer: the ground truth |
//! | [`estimate`] | means of many paths with honest standard errors |
//! | [`receiver`], [`probe`] | irradiance at points, SH radiance at probes |
//! | [`unwrap`] | second UV sets, checked or made |
//! | [`atlas`] | lightmap pages with free rectangles |
//! | [`lightmap`] | the lightmap solver: milliseconds first, converged later |
//! | [`bake`] | lightmaps for files: minutes instead of milliseconds |
//! | [`settings`] | how to solve, as a user writes it down |
//! | [`session`] | scene changes in, lighting updates out: what a thread or a server runs |
//!
//! # Units
//! Lengths in metres; right-handed, y up; linear Rec. 709. Radiometric or photometric, as the caller
//! likes: lights carry intensity (W/sr or cd) or irradiance (W/m² or lx), radiance and irradiance
//! come out in the matching unit.

pub mod atlas;
pub mod bake;
pub mod estimate;
pub mod import;
pub mod lightmap;
pub mod path;
pub mod probe;
pub mod receiver;
pub mod sampling;
pub mod scene;
pub mod session;
pub mod settings;
pub mod sh;
pub mod tracer;
pub mod unwrap;
pub mod visibility;
pub mod world;

pub use scene::{Scene, SceneChange};
pub use tracer::{Hit, Ray, Tracer};
pub use world::World;
