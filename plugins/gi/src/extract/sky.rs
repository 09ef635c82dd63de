//! The sky.

use bevy::{
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};
use farlight_core::{DirectSky, SkyRadiance, SkySource};
use farlight_gi_solver::{
    SceneChange,
    scene::{self, Sky, SkyImage},
};
use std::sync::Arc;

use super::{ExtractedScene, Extractor, pixels};
use crate::status::{GiMeter, Stage};

/// An image of the sky on its way to the solver.
#[derive(Resource, Default)]
pub(crate) struct SkyState {
    image: Option<AssetId<Image>>,
    task: Option<Task<SkyImage>>,
    ready: Option<Arc<SkyImage>>,
    stale: bool,
}

/// Notes how [`SkySource`] differs from what was submitted. An image goes once: a sky that turns or
/// changes its brightness names the same one.
pub(crate) fn extract_sky(
    mut extractor: ResMut<Extractor>,
    extracted: Res<ExtractedScene>,
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
    // Without waiting for an image: the lights that show the direct part are there already.
    let direct = match source.direct {
        DirectSky::Solved => scene::DirectSky::Included,
        DirectSky::ByLights => scene::DirectSky::LeftOut,
    };
    if extracted.scene.direct_sky != direct {
        extractor.changes.lights.push(SceneChange::SetDirectSky(direct));
    }
    let sky = match &source.radiance {
        SkyRadiance::Constant(radiance) => {
            if !source.is_changed() {
                return;
            }
            *state = SkyState::default();
            if is_light(radiance.min_element()) && radiance.is_finite() {
                Sky::Constant(*radiance)
            } else {
                warn_once!("a sky of {radiance} cd/m2 is no light; it counts as black");
                Sky::default()
            }
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
                Some(picture) if arrived || source.is_changed() => {
                    if is_light(*brightness) && rotation.is_finite() {
                        let (image, rotation) = (picture.clone(), *rotation);
                        Sky::Image { image, rotation, scale: *brightness }
                    } else {
                        warn_once!(
                            "a sky of brightness {brightness}, turned by {rotation}, is no light; \
                             it counts as black"
                        );
                        Sky::default()
                    }
                }
                _ => return,
            }
        }
    };
    if extracted.scene.sky != sky {
        extractor.changes.lights.push(SceneChange::SetSky(sky));
    }
}

fn is_light(value: f32) -> bool {
    value.is_finite() && value >= 0.0
}
