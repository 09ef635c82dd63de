//! Farlight brings into a [Bevy](https://bevy.org) game the light that the player's device can't
//! compute. This crate is the door: one feature a plugin, [`FarlightPlugins`] adds what is
//! switched on.
//!
//! | feature | plugin | what |
//! |---|---|---|
//! | `baked` (default) | [`baked::BakedPlugin`] | baked lighting: lightmaps and probes that `farlight bake` made |
//! | `btf` (default) | [`btf::BtfPlugin`] | measured materials, decoded in the shader |
//! | `controls` | `controls::ControlsPlugin` | named actions for keyboard, mouse, gamepad, touch and XR |
//! | `gi` (default) | [`gi::GiPlugin`] | global illumination: lightmaps and probes, solved in the background |
//! | `ibl` (default) | [`ibl::IblPlugin`] | environment light that refines itself |
//! | `panel` | `panel::PanelPlugin` | panels of settings, on screen and in the world |
//! | `remote` | `remote::RemotePlugin` | global illumination, solved on another machine |
//! | `xr` | `xr::FarlightXr` | headsets, by OpenXR |
//!
//! Ten lines bring indirect light into a game:
//!
//! ```no_run
//! use bevy::prelude::*;
//! use farlight::prelude::*;
//!
//! App::new()
//!     .add_plugins((DefaultPlugins, FarlightPlugins))
//!     .insert_resource(GlobalAmbientLight::NONE)
//!     .add_systems(Startup, |mut commands: Commands| {
//!         // Put your level below this entity, now or later.
//!         commands.spawn((GiScene, Transform::default(), Visibility::default()));
//!         // What moves in this box of 10 x 4 x 10 m is lit by probes.
//!         let room = Transform::from_xyz(0.0, 2.0, 0.0).with_scale(Vec3::new(10.0, 4.0, 10.0));
//!         commands.spawn((GiProbeVolume { resolution: UVec3::new(10, 4, 10) }, room));
//!     })
//!     .run();
//! ```
//!
//! Lights, materials and meshes stay Bevy's own.

#[cfg(all(feature = "panel", feature = "xr"))]
mod hands;
#[cfg(feature = "panel")]
mod sections;

use bevy::app::{PluginGroup, PluginGroupBuilder};

/// Baked lighting.
#[cfg(feature = "baked")]
pub use farlight_baked as baked;
/// Measured materials.
#[cfg(feature = "btf")]
pub use farlight_btf as btf;
/// Input actions.
#[cfg(feature = "controls")]
pub use farlight_controls as controls;
/// What the plugins share.
pub use farlight_core as core;
/// Global illumination.
#[cfg(feature = "gi")]
pub use farlight_gi as gi;
/// Environment light that refines itself.
#[cfg(feature = "ibl")]
pub use farlight_ibl as ibl;
/// Panels of settings.
#[cfg(feature = "panel")]
pub use farlight_panel as panel;
/// Global illumination solved on another machine.
#[cfg(feature = "remote")]
pub use farlight_remote as remote;
/// Headsets.
#[cfg(feature = "xr")]
pub use farlight_xr as xr;

/// What the panel's section about the network shows.
#[cfg(all(feature = "panel", feature = "gi"))]
pub use sections::LinkHistory;

/// All plugins whose features are on.
///
/// | plugin | what it is responsible for |
/// |---|---|
/// | [`core::FarlightCorePlugin`] | shared types, texels into textures |
/// | [`baked::BakedPlugin`] | baked light and its scenarios |
/// | [`btf::BtfPlugin`] | measured materials |
/// | [`gi::GiPlugin`] | indirect light |
/// | [`ibl::IblPlugin`] | environment light |
/// | `controls::ControlsPlugin` | input actions |
/// | `panel::PanelPlugin` | panels of settings |
/// | `remote::RemotePlugin` | what a lighting server should know of windows and cameras |
///
/// (`xr::FarlightXr` is none of them: it wraps Bevy's own plugins.)
///
/// Replace one to configure it:
///
/// ```no_run
/// use bevy::prelude::*;
/// use farlight::prelude::*;
///
/// let gi = GiPlugin::default().with_settings_file("lighting/level.gi.ron");
/// App::new().add_plugins((DefaultPlugins, FarlightPlugins.set(gi))).run();
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct FarlightPlugins;

impl PluginGroup for FarlightPlugins {
    fn build(self) -> PluginGroupBuilder {
        let group = PluginGroupBuilder::start::<Self>().add(farlight_core::FarlightCorePlugin);
        #[cfg(feature = "baked")]
        let group = group.add(farlight_baked::BakedPlugin::default());
        #[cfg(feature = "btf")]
        let group = group.add(farlight_btf::BtfPlugin);
        #[cfg(feature = "gi")]
        let group = group.add(farlight_gi::GiPlugin::default());
        #[cfg(feature = "ibl")]
        let group = group.add(farlight_ibl::IblPlugin);
        #[cfg(all(feature = "btf", feature = "ibl"))]
        let group = group.add(WatchMeasured);
        #[cfg(feature = "controls")]
        let group = group.add(farlight_controls::ControlsPlugin::default());
        #[cfg(feature = "panel")]
        let group = group.add(farlight_panel::PanelPlugin::default()).add(sections::SuiteSections);
        #[cfg(all(feature = "panel", feature = "xr"))]
        let group = group.add(hands::PanelHands);
        #[cfg(feature = "remote")]
        let group = group.add(farlight_remote::RemotePlugin);
        group
    }
}

/// Pictures that refine themselves follow measured materials.
#[cfg(all(feature = "btf", feature = "ibl"))]
struct WatchMeasured;

#[cfg(all(feature = "btf", feature = "ibl"))]
impl bevy::app::Plugin for WatchMeasured {
    fn build(&self, app: &mut bevy::app::App) {
        use farlight_ibl::WatchMaterial;
        if app.is_plugin_added::<farlight_ibl::IblPlugin>() {
            app.watch_material::<farlight_btf::BtfMaterial>();
        }
    }
}

/// What most games use.
pub mod prelude {
    pub use crate::FarlightPlugins;
    #[cfg(feature = "baked")]
    pub use farlight_baked::{
        BakedLighting, BakedManifest, BakedPlugin, BakedScene, BakedState, BakedStatus,
        ScenarioWeights,
    };
    #[cfg(feature = "btf")]
    pub use farlight_btf::{BtfAsset, BtfFilter, BtfMaterial, BtfPlugin};
    #[cfg(feature = "controls")]
    pub use farlight_controls::{
        ActiveDevice, AddAction, Controls, ControlsInForce, ControlsPlugin, actions,
    };
    pub use farlight_core::{DerivedLight, DirectSky, SkyRadiance, SkySource};
    #[cfg(feature = "gi")]
    pub use farlight_gi::{
        GiControl, GiDynamic, GiLightmaps, GiPlugin, GiProbeVolume, GiScene, GiSettings, GiState,
        GiStatus, GiUpdated, GiView, LinkState, LinkStatus,
    };
    #[cfg(feature = "ibl")]
    pub use farlight_ibl::{
        AtmosphereEnvironment, EnvironmentBackdrop, EnvironmentMap, EnvironmentStatus, IblPlugin,
        ImageBasedFallback, ProgressiveCamera, ProgressiveLighting, RefinedScreenshot, Refinement,
    };
    #[cfg(feature = "panel")]
    pub use farlight_panel::{
        AddPanel, Notification, PanelPlace, PanelPlugin, PanelRay, PanelSettings, PanelState,
    };
    #[cfg(feature = "remote")]
    pub use farlight_remote::{RemoteBackend, RemoteSettings};
    #[cfg(feature = "xr")]
    pub use farlight_xr::{FarlightXr, XrEye, XrStatus};
}

/// The README's code is compiled as an example of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// So is that of the page about remote lighting.
#[cfg(all(doctest, feature = "remote"))]
#[doc = include_str!("../docs/remote.md")]
struct RemotePage;

/// And that of the page about headsets.
#[cfg(all(doctest, feature = "xr"))]
#[doc = include_str!("../docs/xr.md")]
struct XrPage;

/// And that of the page about panels.
#[cfg(all(doctest, feature = "panel"))]
#[doc = include_str!("../docs/panel.md")]
struct PanelPage;

/// And that of the page about baking.
#[cfg(all(doctest, feature = "baked"))]
#[doc = include_str!("../docs/baking.md")]
struct BakingPage;
