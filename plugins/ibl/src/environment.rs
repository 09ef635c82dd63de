//! Environment maps as assets, and the lights that they become.

use std::sync::Arc;

use bevy::{
    asset::{Asset, AssetLoader, LoadContext, io::Reader},
    prelude::*,
    reflect::TypePath,
    tasks::{AsyncComputeTaskPool, Task, futures::check_ready},
};
use farlight_environment::{
    Environment, EnvironmentError, EnvironmentLight, Layout, LightCache, LightRequest,
};

use crate::{
    ProgressiveLighting,
    settings::LIGHTS,
    status::{EnvironmentState, EnvironmentStatus},
};

/// An environment map: light from all around, as linear radiance.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct EnvironmentMap(pub Arc<Environment>);

/// Loads [`EnvironmentMap`]s from `.hdr`, `.exr` and `.ktx2`.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct EnvironmentMapLoader;

impl AssetLoader for EnvironmentMapLoader {
    type Asset = EnvironmentMap;
    type Settings = ();
    type Error = EnvironmentMapError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        _context: &mut LoadContext<'_>,
    ) -> Result<EnvironmentMap, EnvironmentMapError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Ok(EnvironmentMap(Arc::new(Environment::read(&bytes, Layout::Auto)?)))
    }

    fn extensions(&self) -> &[&str] {
        &["hdr", "exr", "ktx2"]
    }
}

/// Why a file is no environment map.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentMapError {
    /// It can't be read.
    #[error("can't be read: {0}")]
    Io(#[from] std::io::Error),
    /// It is something else.
    #[error(transparent)]
    Content(#[from] EnvironmentError),
}

/// Where chosen lights are kept on disk, so that a map's lights need not be chosen again.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct EnvironmentCache(pub Option<LightCache>);

impl Default for EnvironmentCache {
    /// In the user's folder for such; nowhere in browsers.
    fn default() -> Self {
        Self(LightCache::of_user())
    }
}

/// The lights that stand for the map, in its frame, in the map's unit.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub(crate) struct Lights(pub(crate) Arc<[EnvironmentLight]>);

/// Lights being chosen in the background.
#[derive(Resource, Default)]
pub(crate) struct Choice {
    /// What is chosen or was chosen last.
    wanted: Option<(AssetId<EnvironmentMap>, LightRequest)>,
    task: Option<Task<Arc<[EnvironmentLight]>>>,
}

/// Has lights chosen where map or settings changed.
pub(crate) fn choose(
    settings: Res<ProgressiveLighting>,
    maps: Res<Assets<EnvironmentMap>>,
    server: Res<AssetServer>,
    cache: Res<EnvironmentCache>,
    mut events: MessageReader<AssetEvent<EnvironmentMap>>,
    mut choice: ResMut<Choice>,
    mut lights: ResMut<Lights>,
    mut status: ResMut<EnvironmentStatus>,
) {
    let changed = |id: AssetId<EnvironmentMap>, events: &mut MessageReader<_>| {
        events.read().any(|event: &AssetEvent<_>| event.is_modified(id) || event.is_added(id))
    };
    let Some(handle) = &settings.environment else {
        events.clear();
        *choice = Choice::default();
        lights.set_if_neq(Lights::default());
        status.state = EnvironmentState::None;
        return;
    };
    let id = handle.id();
    let request = LightRequest {
        count: settings.lights.clamp(*LIGHTS.start(), *LIGHTS.end()),
        method: settings.method,
        seed: settings.seed,
    };
    let anew = changed(id, &mut events) || choice.wanted != Some((id, request));
    match maps.get(id) {
        Some(map) if anew => {
            let map = map.0.clone();
            choice.wanted = Some((id, request));
            let cache = cache.0.clone();
            choice.task = Some(AsyncComputeTaskPool::get().spawn(async move {
                match cache {
                    Some(cache) => cache.lights(&map, &request).into(),
                    None => map.lights(&request).into(),
                }
            }));
            status.state = EnvironmentState::Choosing;
        }
        Some(_) => {}
        None => {
            // What is being chosen from another map is no longer wanted; the lights before shine on.
            choice.wanted = None;
            choice.task = None;
            status.state = match server.get_load_state(id) {
                Some(bevy::asset::LoadState::Failed(error)) => {
                    EnvironmentState::Failed(error.to_string().into())
                }
                _ => EnvironmentState::Loading,
            };
        }
    }
    if let Some(task) = &mut choice.task
        && let Some(chosen) = check_ready(task)
    {
        choice.task = None;
        status.state = EnvironmentState::Ready;
        lights.set_if_neq(Lights(chosen));
    }
}
