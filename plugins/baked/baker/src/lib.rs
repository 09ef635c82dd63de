//! Baked lighting: from a glTF file to a lit one.
//!
//! [`Bake`] reads a scene and writes a folder: the scene with second UV sets, lightmap pages, irradiance
//! volumes, and a manifest that names them. It shows no progress and knows no command line: an
//! [`Observer`] hears how far it is.
//!
//! | module | what |
//! |---|---|
//! | [`gltf`] | the file that is read, and the lit scene that is written |
//! | [`uv`] | which primitive gets which second UV set, and how many texels |
//! | [`lights`] | added lights, and scenarios |
//!
//! The files and their meaning are those of [`farlight_baked_format`].
//!
//! ```no_run
//! use farlight_baker::{Bake, BakeOptions};
//!
//! let report = Bake::new(BakeOptions::new("room.glb", "lit")).run(&mut ())?;
//! println!("{}", report.manifest_path.display());
//! # Ok::<(), farlight_baker::BakeError>(())
//! ```

mod bake;
mod error;
pub mod gltf;
pub mod lights;
mod observer;
mod options;
mod report;
mod store;
pub mod uv;
mod watch;

pub use bake::Bake;
pub use error::BakeError;
pub use observer::{Event, Observer, Progress, Stage};
pub use options::{BakeOptions, EMISSIVE_EV100, Effort, Emission, Probes, Quality, Texels};
pub use report::{Outcome, Report};
pub use watch::watch;
