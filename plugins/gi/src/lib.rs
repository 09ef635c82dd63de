//! Global illumination for Bevy, solved in the background.
//!
//! Direct light stays Bevy's own. What Bevy doesn't compute (light that has been reflected, light
//! of emissive surfaces, the sky) is solved while the game runs and streamed into Bevy's
//! `Lightmap`s for static meshes and `IrradianceVolume`s for everything else, so that a game of
//! `StandardMaterial`s works unchanged.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use farlight_gi::{GiPlugin, GiProbeVolume, GiScene};
//!
//! App::new().add_plugins((DefaultPlugins, GiPlugin::default())).add_systems(Startup, setup).run();
//!
//! fn setup(mut commands: Commands) {
//!     // Tag the root of the level, here or later, loaded or not.
//!     commands.spawn((GiScene, Transform::default(), Visibility::default()));
//!     // Things that move are lit by probes in this box of 10 x 4 x 10 m.
//!     let volume = Transform::from_xyz(0.0, 2.0, 0.0).with_scale(Vec3::new(10.0, 4.0, 10.0));
//!     commands.spawn((GiProbeVolume { resolution: UVec3::new(10, 4, 10) }, volume));
//! }
//! ```
//!
//! Bevy adds an ambient light of its own by default; set `GlobalAmbientLight::NONE`, or it is seen
//! on top.
//!
//! # What happens
//! Every frame, changes of tagged meshes, their materials, all lights (but those marked
//! [`DerivedLight`](farlight_core::DerivedLight)) and the [`SkySource`](farlight_core::SkySource)
//! go to a [`LightingBackend`], by default a solver in a thread of its own ([`ThreadBackend`]).
//! Its updates are written into textures, a bounded number of bytes a frame.
//! [`GiStatus`] says how it is going and what is left out, and why; [`GiUpdated`] is sent when new
//! light is in the textures; [`GiControl`] switches indirect light off and on; [`GiView`] shows
//! parts of it.
//!
//! # Units
//! Bevy's: lumens, lux, cd/m². Texels and voxels hold E / π in cd/m² for
//! `StandardMaterial::lightmap_exposure` 1.

mod backend;
mod components;
mod control;
mod extract;
mod lightmaps;
mod link;
mod plugin;
mod receive;
mod settings;
mod status;
mod tag;
#[cfg(not(target_arch = "wasm32"))]
mod thread;
mod uv1;
mod view;
mod volumes;

pub use backend::{
    BackendFactory, BackendState, EncodedGrid, EncodedTile, GiBackend, GiUpdate, LightingBackend,
    UpdateTimes,
};
pub use components::{GiDynamic, GiProbeVolume, GiScene, GiStatic};
pub use control::{GiControl, GiView};
pub use extract::ExtractedScene;
#[cfg(not(target_arch = "wasm32"))]
pub use farlight_gi_solver::session::Solve;
pub use lightmaps::GiLightmaps;
pub use link::{LinkState, LinkStatus};
pub use plugin::{GiPlugin, GiSystems};
pub use settings::GiSettings;
pub use status::{GiState, GiStatus, GiTimings, GiUpdated, StageTimes};
#[cfg(not(target_arch = "wasm32"))]
pub use thread::ThreadBackend;

/// The solver's types that the seam speaks of.
pub use farlight_gi_solver as solver;
