//! Environment light that refines itself: an environment map becomes directional lights, a few of
//! them shine in each frame, and the pictures of many frames become one.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use farlight_ibl::{IblPlugin, ProgressiveCamera, ProgressiveLighting};
//!
//! fn setup(mut commands: Commands, server: Res<AssetServer>) {
//!     commands.insert_resource(ProgressiveLighting {
//!         environment: Some(server.load("environments/sky.hdr")),
//!         brightness: 1000.0,
//!         ..default()
//!     });
//!     commands.spawn((ProgressiveCamera::default(), Transform::from_xyz(0.0, 1.0, 4.0)));
//! }
//!
//! App::new().add_plugins((DefaultPlugins, IblPlugin)).add_systems(Startup, setup).run();
//! ```
//!
//! # How it works
//! The map's [`lights`](ProgressiveLighting::lights) are split into groups of
//! [`per_frame`](ProgressiveLighting::per_frame). One group shines in a frame, as many times brighter
//! as there are groups: each frame is an unbiased estimate of the whole, and the mean over a cycle of
//! groups is the light of all of them, with soft shadows. After J. Schiller, *BTF rendering in
//! virtual reality* (2022), chapters 6.5, 6.6, 7.6 and 7.7, whose pictures start anew at every
//! motion; here they move along ([`ProgressiveCamera`]).
//!
//! The lights are Bevy's own `DirectionalLight`s, marked `DerivedLight`, so that every material is
//! lit by them; the game's own lights keep their places among the ten that Bevy draws. The map is
//! the app's [`SkySource`](farlight_core::SkySource): plugins that solve indirect light know it, and
//! leave what comes straight from it to the lights.

mod atmosphere;
mod camera;
mod cascades;
mod changes;
mod dots;
mod environment;
mod groups;
mod layers;
mod lights;
mod relit;
mod render;
mod screenshot;
mod settings;
mod sky;
mod skybox;
mod status;
#[cfg(test)]
mod twin;
mod uniform;

use bevy::{
    asset::AssetEventSystems,
    camera::{CameraUpdateSystems, visibility::VisibilitySystems},
    light::{DirectionalLightShadowMap, SimulationLightSystems},
    prelude::*,
};
use farlight_core::{FarlightCorePlugin, LightmapSystems};

pub use atmosphere::{AtmosphereEnvironment, AtmosphereState, CaptureAtmosphere};
pub use camera::{ProgressiveCamera, Refinement};
pub use changes::{Disturb, WatchMaterial};
pub use dots::{EnvironmentDots, EnvironmentLights};
pub use environment::{
    EnvironmentCache, EnvironmentMap, EnvironmentMapError, EnvironmentMapLoader,
};
pub use farlight_environment as environment_maps;
pub use screenshot::RefinedScreenshot;
pub use settings::{LIGHTS, PER_FRAME, ProgressiveLighting};
pub use skybox::{EnvironmentBackdrop, ImageBasedFallback};
pub use status::{EnvironmentState, EnvironmentStatus};

/// When this crate's systems run, all in `PostUpdate`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum IblSystems {
    /// The group of the frame shines; before transforms are propagated.
    Shine,
    /// Changes are noticed, and each camera's step is decided; after transforms and visibility are
    /// known.
    Decide,
}

/// Adds environment light. See [`ProgressiveLighting`] and [`ProgressiveCamera`].
#[derive(Clone, Copy, Debug, Default)]
pub struct IblPlugin;

impl Plugin for IblPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<FarlightCorePlugin>() {
            app.add_plugins(FarlightCorePlugin);
        }
        // Without Bevy's lights and materials, as on a server, there is nothing to shine on.
        let has_scene = resource_exists::<DirectionalLightShadowMap>
            .and_then(resource_exists::<Assets<StandardMaterial>>)
            .and_then(resource_exists::<Assets<Mesh>>)
            .and_then(resource_exists::<Assets<Image>>);
        app.init_asset::<EnvironmentMap>()
            .register_asset_loader(EnvironmentMapLoader)
            .register_type::<ProgressiveLighting>()
            .register_type::<ProgressiveCamera>()
            .register_type::<Refinement>()
            .register_type::<EnvironmentBackdrop>()
            .register_type::<ImageBasedFallback>()
            .add_message::<Disturb>()
            .init_resource::<ProgressiveLighting>()
            .init_resource::<EnvironmentStatus>()
            .init_resource::<EnvironmentCache>()
            .init_resource::<environment::Lights>()
            .init_resource::<environment::Choice>()
            .init_resource::<groups::Arranged>()
            .init_resource::<lights::Group>()
            .init_resource::<skybox::Cubes>()
            .init_resource::<changes::Changes>()
            .init_resource::<sky::SkyImage>()
            .configure_sets(
                PostUpdate,
                (
                    IblSystems::Shine
                        .before(TransformSystems::Propagate)
                        .after(AssetEventSystems)
                        .run_if(has_scene.clone()),
                    IblSystems::Decide
                        .after(TransformSystems::Propagate)
                        .after(CameraUpdateSystems)
                        .after(VisibilitySystems::VisibilityPropagate)
                        .after(VisibilitySystems::CalculateBounds)
                        .run_if(has_scene.clone()),
                ),
            )
            .add_systems(
                PostUpdate,
                (
                    (
                        environment::choose,
                        lights::shine,
                        sky::claim,
                        skybox::forget,
                        skybox::show_backdrops,
                        skybox::fall_back,
                    )
                        .chain()
                        .in_set(IblSystems::Shine),
                    (camera::forget, camera::decide, screenshot::take)
                        .chain()
                        .in_set(IblSystems::Decide),
                    cascades::fit
                        .after(SimulationLightSystems::UpdateDirectionalLightCascades)
                        .after(VisibilitySystems::CalculateBounds)
                        .after(VisibilitySystems::VisibilityPropagate)
                        .before(SimulationLightSystems::UpdateLightFrusta)
                        .run_if(has_scene),
                ),
            );
        app.add_systems(
            PostUpdate,
            relit::notice.after(LightmapSystems::Notice).before(IblSystems::Decide),
        );
        atmosphere::build(app);
        changes::build(app);
        render::build(app);
        dots::build(app);
    }
}
