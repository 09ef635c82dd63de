//! The sky.

use bevy::{
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};
use farlight_core::{SkyRadiance, SkySource};
use farlight_gi_solver::{
    SceneChange,
    scene::{Sky, SkyImage},
};
use std::sync::Arc;

use super::{Extractor, pixels};
use crate::status::{GiMeter, Stage};

/// An image of the sky on its way to the solver.
#[derive(Resource, Default)]
pub(crate) struct SkyState {
    image: Option<AssetId<Image>>,
    task: Option<Task<SkyImage>>,
    ready: Option<Arc<SkyImage>>,
    stale: bool,
}

/// Notes changes of [`SkySource`].
pub(crate) fn extract_sky(
    mut extractor: ResMut<Extractor>,
    mut state: ResMut<SkyState>,
    source: Res<SkySource>,
    mut events: MessageReader<AssetEvent<Image>>,
    images: Res<Assets<Image>>,
    meter: Res<GiMeter>,
) {
    let _measure = meter.measure(Stage::Extract as usize);
    let changed = events.read().any(|event| match event {
        AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id) == state.image,
        _ => false,
    });
    let sky = match &source.radiance {
        SkyRadiance::Constant(radiance) => {
            if !source.is_changed() {
                return;
            }
            *state = SkyState::default();
            let valid = radiance.is_finite() && radiance.min_element() >= 0.0;
            if !valid {
                warn!("a sky of {radiance} cd/m2 is no light; it counts as black");
            }
            Sky::Constant(if valid { *radiance } else { Vec3::ZERO })
        }
        SkyRadiance::Equirect { image, rotation, brightness } => {
            if state.image != Some(image.id()) || changed {
                *state = SkyState { image: Some(image.id()), stale: true, ..Default::default() };
            }
            if state.stale
                && let Some(picture) = images.get(image)
            {
                state.stale = false;
                if let Some(problem) = pixels::problem(picture) {
                    warn!("the sky's image is left out of the indirect light: {problem}");
                    return;
                }
                let copy = picture.clone();
                let task = AsyncComputeTaskPool::get().spawn(async move { pixels::sky(&copy) });
                state.task = Some(task);
            }
            let arrived = match state.task.as_mut().map(|task| block_on(poll_once(task))) {
                Some(Some(picture)) => {
                    state.task = None;
                    state.ready = Some(Arc::new(picture));
                    true
                }
                _ => false,
            };
            match &state.ready {
                Some(picture) if arrived || source.is_changed() => Sky::Image {
                    image: picture.clone(),
                    rotation: *rotation,
                    scale: brightness.max(0.0),
                },
                _ => return,
            }
        }
    };
    extractor.changes.lights.push(SceneChange::SetSky(sky));
}
