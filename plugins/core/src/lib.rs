//! What the Farlight plugins share, kept tiny.
//!
//! | item | for |
//! |---|---|
//! | [`DerivedLight`] | lights that a plugin made; no plugin reads them as lights of the scene |
//! | [`BakedSurface`] | meshes whose light was computed before |
//! | [`ShadowProxy`] | meshes that only cast shadows, for others |
//! | [`field`] | what settings say of their fields, for panels |
//! | [`DiffuseReflectance`] | what surfaces reflect whose material lighting does not know |
//! | [`LightingChanged`] | solved light on surfaces has become another |
//! | [`LightmapSystems`] | lightmaps come and go before materials look for them |
//! | [`SkySource`] | the one sky that lighting counts |
//! | [`shader_path`] | the suite's shader modules, embedded |
//! | [`TextureUploads`] | texels into existing textures, a bounded number of bytes a frame |
//! | [`RonPlugin`], [`RonSettings`] | configuration files as hot-reloaded assets, errors with file, line and field |
//! | [`LeftOut`], [`TimeStats`], [`TimeWindow`], [`CostMeter`] | what status resources are made of |
//!
//! Add [`FarlightCorePlugin`] once; the plugins that need it do so themselves.

mod cost;
pub mod field;
mod light;
mod ron_asset;
mod shaders;
mod sky;
mod status;
mod surface;
mod upload;

use bevy::app::{App, Plugin};

pub use cost::{CostMeter, Measured, process_cpu_time, thread_cpu_time};
pub use light::DerivedLight;
pub use ron_asset::{FieldProblem, RonError, RonLoader, RonPlugin, RonSettings, parse_ron};
pub use shaders::shader_path;
pub use sky::{DirectSky, SkyRadiance, SkySource, SkyTaken};
pub use status::{LeftOut, TimeStats, TimeWindow};
pub use surface::{
    BakedSurface, DiffuseReflectance, LightingChanged, LightmapSystems, ShadowProxy,
};
pub use upload::{Region, RegionProblem, TextureUploads, Ticket, UploadProgress};

/// Registers the shared types, the shader modules and the texture uploader. Add it after the engine's
/// own plugins.
#[derive(Clone, Copy, Debug, Default)]
pub struct FarlightCorePlugin;

impl Plugin for FarlightCorePlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<DerivedLight>().init_resource::<SkySource>();
        shaders::build(app);
        surface::build(app);
        upload::build(app);
    }

    fn is_unique(&self) -> bool {
        true
    }
}
