//! The plugin.

use std::sync::Arc;

use bevy::{
    asset::AssetEventSystems, camera::visibility::VisibilitySystems,
    mesh::mark_3d_meshes_as_changed_if_their_assets_changed,
    pbr::check_entities_needing_specialization, prelude::*,
};
use farlight_core::{FarlightCorePlugin, LightmapSystems, RonPlugin};

use crate::{
    ExtractedScene, GiControl, GiDynamic, GiLightmaps, GiProbeVolume, GiScene, GiSettings,
    GiStatus, GiUpdated, GiView, LightingBackend,
    backend::BackendFactory,
    extract::{self, Extractor, SkyState},
    receive::{self, Factory, OnTheWay},
    status::{self, GiMeter, Remarks},
    tag, view,
    volumes::Volumes,
};

/// Solves and shows indirect light. See the [crate](crate) for how to use it.
pub struct GiPlugin {
    factory: BackendFactory,
    settings: Option<String>,
}

/// The plugin's systems, in `PostUpdate`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GiSystems {
    /// Takes updates of the backend over, and inserts and removes `Lightmap`s; before Bevy looks
    /// for changed materials.
    Apply,
    /// Passes tags on to meshes; after [`Self::Apply`].
    Tag,
    /// Reads the scene and submits changes; after [`Self::Tag`] and after Bevy has propagated
    /// transforms and visibility.
    Extract,
}

impl Default for GiPlugin {
    /// Solves in a background thread. (On the web, which has no threads here, the plugin says
    /// that it failed; give it another backend.)
    fn default() -> Self {
        Self::with_backend(default_backend)
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn default_backend(settings: &GiSettings) -> Box<dyn LightingBackend> {
    Box::new(crate::ThreadBackend::new(settings.session()))
}

#[cfg(target_arch = "wasm32")]
fn default_backend(_settings: &GiSettings) -> Box<dyn LightingBackend> {
    use farlight_gi_solver::session::{SessionChange, SnapshotId};

    struct NoThreads;

    impl LightingBackend for NoThreads {
        fn submit(&mut self, _: SnapshotId, _: Vec<SessionChange>) {}

        fn poll(&mut self) -> Option<crate::GiUpdate> {
            None
        }

        fn state(&self) -> crate::BackendState {
            crate::BackendState::Failed("there are no threads on the web".into())
        }
    }

    Box::new(NoThreads)
}

impl GiPlugin {
    /// Solves with what `factory` makes: at the start, and when settings of the solver change.
    pub fn with_backend(
        factory: impl Fn(&GiSettings) -> Box<dyn LightingBackend> + Send + Sync + 'static,
    ) -> Self {
        Self { factory: Arc::new(factory), settings: None }
    }

    /// Takes the settings from an asset, a `GiSettings(...)` in a RON file (extension `gi.ron`),
    /// now and whenever the file changes and assets are watched. Until it is loaded, and when it
    /// has an error, the [`GiSettings`] resource stays as it is.
    #[must_use]
    pub fn with_settings_file(mut self, path: impl Into<String>) -> Self {
        self.settings = Some(path.into());
        self
    }
}

/// The settings' file.
#[derive(Resource)]
struct SettingsFile(Handle<GiSettings>);

impl Plugin for GiPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<FarlightCorePlugin>() {
            app.add_plugins(FarlightCorePlugin);
        }
        app.add_plugins(RonPlugin::<GiSettings>::default())
            .register_type::<GiScene>()
            .register_type::<GiDynamic>()
            .register_type::<GiProbeVolume>()
            .register_type::<GiControl>()
            .register_type::<GiView>()
            .insert_resource(Factory(self.factory.clone()))
            .init_resource::<GiSettings>()
            .init_resource::<GiControl>()
            .init_resource::<GiView>()
            .init_resource::<GiStatus>()
            .init_resource::<GiLightmaps>()
            .init_resource::<ExtractedScene>()
            .init_resource::<GiMeter>()
            .init_resource::<Remarks>()
            .init_resource::<Extractor>()
            .init_resource::<SkyState>()
            .init_resource::<Volumes>()
            .init_resource::<OnTheWay>()
            .add_message::<GiUpdated>();
        if let Some(path) = &self.settings {
            let handle = app.world().resource::<AssetServer>().load(path.clone());
            app.insert_resource(SettingsFile(handle)).add_systems(PreUpdate, load_settings);
        }

        let has_assets = resource_exists::<Assets<StandardMaterial>>
            .and_then(resource_exists::<Assets<Mesh>>)
            .and_then(resource_exists::<Assets<Image>>);
        app.configure_sets(
            PostUpdate,
            (GiSystems::Apply, GiSystems::Tag, GiSystems::Extract).chain().run_if(has_assets),
        )
        .configure_sets(
            PostUpdate,
            GiSystems::Apply
                .in_set(LightmapSystems::Change)
                .before(check_entities_needing_specialization::<StandardMaterial>)
                .before(mark_3d_meshes_as_changed_if_their_assets_changed),
        )
        .configure_sets(
            PostUpdate,
            GiSystems::Extract
                .after(TransformSystems::Propagate)
                .after(VisibilitySystems::VisibilityPropagate)
                .after(AssetEventSystems),
        )
        .add_systems(
            PostUpdate,
            (
                (
                    receive::start_backend,
                    extract::swap_meshes,
                    receive::receive,
                    view::switch_views,
                )
                    .chain()
                    .in_set(GiSystems::Apply),
                tag::propagate_tags.in_set(GiSystems::Tag),
                (
                    extract::convert_meshes,
                    extract::convert_textures,
                    extract::extract_materials,
                    extract::extract_instances,
                    extract::extract_lights,
                    extract::extract_sky,
                    extract::extract_volumes,
                    extract::submit,
                )
                    .chain()
                    .in_set(GiSystems::Extract),
            ),
        )
        .add_systems(Last, status::end_frame)
        .add_systems(PostStartup, warn_about_ambient_light);
    }
}

fn load_settings(
    file: Res<SettingsFile>,
    mut events: MessageReader<AssetEvent<GiSettings>>,
    loaded: Res<Assets<GiSettings>>,
    mut settings: ResMut<GiSettings>,
) {
    for event in events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event
            && *id == file.0.id()
            && let Some(loaded) = loaded.get(*id)
            && *settings != *loaded
        {
            *settings = loaded.clone();
        }
    }
}

fn warn_about_ambient_light(ambient: Option<Res<GlobalAmbientLight>>) {
    if ambient.is_some_and(|ambient| ambient.brightness > 0.0) {
        info!(
            "Bevy's ambient light is added to the solved indirect light; insert \
             GlobalAmbientLight::NONE to see the latter alone"
        );
    }
}
