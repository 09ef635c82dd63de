//! The plugin.

use bevy::{
    camera::visibility::VisibilitySystems, mesh::mark_3d_meshes_as_changed_if_their_assets_changed,
    pbr::check_entities_needing_specialization, prelude::*,
};
use farlight_core::{FarlightCorePlugin, LightmapSystems};

use crate::{
    BakedLighting, BakedManifest, BakedPart, BakedScene, BakedStatus, Blending, backs, blend,
    manifest::BakedManifestLoader,
    root::Fingerprints,
    scene,
    update::{self, Roots},
};

/// Shows baked lighting. See the [crate](crate) for how to use it.
#[derive(Clone, Copy, Debug, Default)]
pub struct BakedPlugin {
    /// Blends scenarios on the CPU even where the GPU could: to see what players on WebGL2 see.
    pub blend_on_cpu: bool,
}

/// The plugin's systems, in `PostUpdate`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BakedSystems {
    /// Notices what changed and inserts lightmaps, volumes and lights; part of
    /// [`LightmapSystems::Change`], before Bevy propagates transforms.
    Apply,
}

impl Plugin for BakedPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<FarlightCorePlugin>() {
            app.add_plugins(FarlightCorePlugin);
        }
        app.init_asset::<BakedManifest>()
            .preregister_asset_loader::<BakedManifestLoader>(BakedManifestLoader::EXTENSIONS)
            .register_type::<BakedLighting>()
            .register_type::<BakedScene>()
            .register_type::<BakedPart>()
            .init_resource::<BakedStatus>()
            .init_resource::<Roots>()
            .init_resource::<Fingerprints>();
        blend::build(app);

        let has_assets = resource_exists::<Assets<StandardMaterial>>
            .and_then(resource_exists::<Assets<Mesh>>)
            .and_then(resource_exists::<Assets<Image>>);
        app.configure_sets(
            PostUpdate,
            BakedSystems::Apply
                .in_set(LightmapSystems::Change)
                .before(TransformSystems::Propagate)
                .before(VisibilitySystems::VisibilityPropagate)
                .before(check_entities_needing_specialization::<StandardMaterial>)
                .before(mark_3d_meshes_as_changed_if_their_assets_changed)
                .run_if(has_assets),
        )
        .add_systems(PreUpdate, (scene::load, scene::spawn).chain())
        .add_systems(
            PostUpdate,
            (update::notice, update::update, backs::cast).chain().in_set(BakedSystems::Apply),
        );
    }

    fn finish(&self, app: &mut App) {
        let blending = match blend::who(app) {
            Blending::Gpu if self.blend_on_cpu => Blending::Cpu,
            blending => blending,
        };
        blend::finish(app, blending);
        if blending == Blending::Cpu {
            info!("scenarios of baked light are blended on the CPU");
        }
        app.world_mut().resource_mut::<BakedStatus>().blending = blending;
        // Manifests that were asked for before have waited.
        app.register_asset_loader(BakedManifestLoader { keep_texels: blending == Blending::Cpu });
    }
}
