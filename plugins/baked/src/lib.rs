//! Baked lighting for Bevy: a whole scene is lit by what `farlight bake` made of it, and its scenarios
//! (morning, noon, lamp on) are blended while the game runs.
//!
//! ```text
//! farlight bake room.glb --out assets/room
//! ```
//!
//! ```no_run
//! use bevy::prelude::*;
//! use farlight_baked::{BakedPlugin, BakedScene};
//!
//! App::new()
//!     .add_plugins((DefaultPlugins, BakedPlugin::default()))
//!     .insert_resource(GlobalAmbientLight::NONE)
//!     .add_systems(Startup, |mut commands: Commands| {
//!         commands.spawn(BakedScene("room/room.baked.ron".into()));
//!     })
//!     .run();
//! ```
//!
//! A game that loads the .glb file of the bake itself puts [`BakedLighting`] on the entity with its
//! `WorldAssetRoot` instead.
//!
//! # What happens
//! | of the manifest | becomes |
//! |---|---|
//! | receivers | a `Lightmap` on each mesh entity; its second UV set must be the one that was baked |
//! | volumes | child entities with Bevy's `LightProbe` and `IrradianceVolume`, for what has no lightmap |
//! | lights of the file | intensity, range and radius as baked, `affects_lightmapped_mesh_diffuse` off where lightmaps hold their direct light |
//! | lights that the bake added | child entities with lights that cast shadows |
//!
//! Backs of single-sided lit meshes cast shadows in all these lights ([`BakedLighting::solid_backs`]).
//!
//! A light whose direct light is baked still lights what has no lightmap, and still shines on
//! lightmapped surfaces (their specular reflection). All children carry [`BakedPart`].
//!
//! Meshes are found by what the baker noted in the file (`extras.farlight_node`) and by the
//! primitive's index, so the scene may be spawned late, again, several times, and moved as a whole.
//! What can't be lit is listed in [`BakedStatus`] with the reason, and the rest is lit.
//!
//! # Scenarios
//! ```
//! use farlight_baked::BakedLighting;
//!
//! let mut lighting = BakedLighting::default();
//! lighting.scenarios.show("noon");
//! lighting.scenarios.blend("noon", "evening", 0.3);
//! lighting.scenarios.set("lamp", 0.5);
//! ```
//!
//! Pages and volumes are blended into half floats by a compute shader when weights change; a frame in
//! which they don't costs nothing. Lights follow the weights too. A manifest with a single scenario at
//! weight 1 is shown as it was loaded. See [`ScenarioWeights`] for what weights mean.
//!
//! # With other plugins
//! Lit meshes carry `farlight_core`'s `BakedSurface`: `farlight_gi` lets them block and reflect light and
//! gives them no lightmap of its own, whichever tag comes first. So a level may be baked while doors and
//! furniture below a `GiScene` are solved live; lights of the bake take part in that. Of probe volumes that overlap,
//! Bevy takes the nearest: don't place a `GiProbeVolume` over a baked one. Materials of
//! `farlight_btf` show lightmaps as Bevy's do.
//!
//! Bevy adds an ambient light of its own by default; set `GlobalAmbientLight::NONE`, or it is seen
//! on top of baked light.
//!
//! # Limits
//! - What moves casts no shadow of a baked light onto lightmapped surfaces: bake such a light with
//!   `direct: Realtime`.
//! - Bevy's shadow maps leave out the backs of single-sided materials. Lights of a bake see twins of such walls
//!   ([`SHADOW_LAYER`]); a game's own sun shines through them.
//! - On the web Bevy has no irradiance volumes.
//! - Changes of `bicubic`, of lightmaps' places by another bake, and the first dimming of a single scenario
//!   that is not `dimmable` cost a frame without lightmaps: Bevy takes a lightmap's place only once.
//!
//! # Units
//! Bevy's: lumens, lux, cd/m². Texels and voxels hold E / π in cd/m² for
//! `StandardMaterial::lightmap_exposure` 1.

mod backs;
mod blend;
mod components;
mod find;
mod lights;
mod manifest;
mod plugin;
mod root;
mod scenarios;
mod scene;
mod status;
mod textures;
mod update;
mod volumes;

pub use backs::SHADOW_LAYER;
pub use blend::twin;
pub use components::{BakedLighting, BakedPart, BakedScene};
pub use manifest::{BakedManifest, BakedManifestError};
pub use plugin::{BakedPlugin, BakedSystems};
pub use scenarios::{MOST_SCENARIOS, ScenarioWeights};
pub use status::{BakedRoot, BakedState, BakedStatus, Blending};

/// The types of the manifest.
pub use farlight_baked_format as format;
