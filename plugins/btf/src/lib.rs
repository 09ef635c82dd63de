//! Measured materials in Bevy: a [`BtfMaterial`] shows a surface as it was measured for every
//! direction of light and view, decoded in the shader from a few megabytes.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use farlight_btf::{BtfMaterial, BtfPlugin};
//!
//! fn setup(
//!     mut commands: Commands,
//!     server: Res<AssetServer>,
//!     mut meshes: ResMut<Assets<Mesh>>,
//!     mut materials: ResMut<Assets<BtfMaterial>>,
//! ) {
//!     commands.spawn((
//!         Mesh3d(meshes.add(Sphere::default())),
//!         MeshMaterial3d(materials.add(BtfMaterial {
//!             repeat: Vec2::new(8.0, 4.0),
//!             ..BtfMaterial::new(server.load("materials/cloth.fbtf"))
//!         })),
//!     ));
//! }
//!
//! App::new().add_plugins((DefaultPlugins, BtfPlugin)).add_systems(Startup, setup).run();
//! ```
//!
//! # What is seen
//! All of Bevy's point, spot and directional lights with their shadows, by a loop of our own
//! (`shaders/lighting/`); environment maps and reflection probes, met at fixed directions
//! ([`BtfSettings`]); lightmaps, irradiance volumes and ambient light times the material's albedo
//! for the view; fog, exposure, tone mapping, ambient occlusion and contact shadows as
//! `StandardMaterial` has them. Measured data does not part diffuse light from mirrored: a light
//! that a lightmap holds already is left out on its meshes, and so is the environment where a
//! lightmap or an irradiance volume holds it.
//!
//! Entities carry a `DiffuseReflectance` of `farlight_core`, the material's mean colour: so
//! `farlight_gi` gives them lightmaps, and lets them block and reflect light.
//!
//! Left out: rectangular lights, textures of lights, decals, transparency, the deferred renderer
//! (materials are always drawn forward).
//!
//! # Where it lies
//! The data of all materials is in few storage buffers; materials of one buffer are drawn with one
//! bind group, so that Bevy batches them. A device without storage buffers in fragment shaders
//! (WebGL2) shows diffuse surfaces of the materials' mean colours. [`BtfStatus`] says which, and
//! which files could not be read.

mod asset;
mod bind_groups;
mod coarse;
mod entry;
mod loading;
mod material;
mod page;
mod reflectance;
mod settings;
mod spans;
mod status;
mod tables;

use bevy::{
    asset::AssetEventSystems,
    pbr::{MaterialPlugin, PbrPlugin, check_entities_needing_specialization},
    prelude::*,
    render::{
        ExtractSchedule, GpuResourceAppExt, Render, RenderApp, RenderSystems,
        erased_render_asset::prepare_erased_assets, extract_resource::ExtractResourcePlugin,
    },
};
use farlight_core::{DiffuseReflectance, FarlightCorePlugin, LightmapSystems};

pub use asset::{BtfAsset, BtfLoader};
pub use farlight_btf_codec as codec;
pub use material::{BtfFilter, BtfMaterial, BtfMaterialKey};
pub use settings::BtfSettings;
pub use status::{BtfFailure, BtfStatus};

/// Adds [`BtfMaterial`] and the loader of material files.
#[derive(Clone, Copy, Debug, Default)]
pub struct BtfPlugin;

impl Plugin for BtfPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<FarlightCorePlugin>() {
            app.add_plugins(FarlightCorePlugin);
        }
        let report = status::SharedReport::default();
        app.init_asset::<BtfAsset>()
            .register_asset_loader(BtfLoader)
            .register_type::<BtfSettings>()
            .init_resource::<BtfSettings>()
            .init_resource::<BtfStatus>()
            .init_resource::<loading::PreparedBtfs>()
            .insert_resource(report.clone())
            .add_systems(
                Update,
                (status::take_report, status::note_failures, loading::finish).chain(),
            )
            .add_systems(
                PostUpdate,
                (loading::start, reflectance::update).after(AssetEventSystems),
            );

        // From the first moment, so that lighting waits for it. Where that can't be, for meshes are
        // there already, it comes a frame later.
        drop(app.try_register_required_components::<MeshMaterial3d<BtfMaterial>, DiffuseReflectance>());

        // Without a renderer there is nothing to draw, but assets and meshes may still name materials.
        if app.get_sub_app(RenderApp).is_none() || !app.is_plugin_added::<PbrPlugin>() {
            app.init_asset::<BtfMaterial>();
            return;
        }
        app.add_plugins((
            MaterialPlugin::<BtfMaterial>::default(),
            ExtractResourcePlugin::<BtfSettings>::default(),
        ));
        app.add_systems(
            PostUpdate,
            material::notice_lightmaps
                .in_set(LightmapSystems::Notice)
                .before(check_entities_needing_specialization::<BtfMaterial>),
        );
        let prepare = prepare_erased_assets::<MeshMaterial3d<BtfMaterial>>;
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app
                .insert_resource(report)
                .init_gpu_resource::<tables::BtfTables>()
                .init_gpu_resource::<bind_groups::SharedGroups>()
                .add_systems(ExtractSchedule, tables::extract)
                .add_systems(
                    Render,
                    (
                        (tables::upload, bind_groups::restore).chain().before(prepare),
                        bind_groups::share.after(prepare),
                    )
                        .in_set(RenderSystems::PrepareAssets),
                );
        }
    }
}
