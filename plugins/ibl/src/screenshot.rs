//! Screenshots that wait until the picture is refined.

use bevy::{camera::RenderTarget, prelude::*, render::view::screenshot::Screenshot};

use crate::{ProgressiveCamera, Refinement};

/// A screenshot of what a [`ProgressiveCamera`] draws into (its window or its image, all of it), taken in
/// the first frame in which that camera's picture is refined. A camera that doesn't accumulate is taken
/// at once.
///
/// Spawned on an entity of its own, like Bevy's [`Screenshot`], which it becomes: observers get
/// `ScreenshotCaptured`, then the entity vanishes. If the camera is gone before, nothing is taken.
///
/// ```
/// # use bevy::{prelude::*, render::view::screenshot::save_to_disk};
/// # use farlight_ibl::{ProgressiveCamera, RefinedScreenshot};
/// fn take(mut commands: Commands, camera: Single<Entity, With<ProgressiveCamera>>) {
///     commands.spawn(RefinedScreenshot(*camera)).observe(save_to_disk("refined.png"));
/// }
/// # bevy::ecs::system::assert_is_system(take);
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct RefinedScreenshot(
    /// The camera.
    pub Entity,
);

/// Takes those whose camera is ready.
pub(crate) fn take(
    mut commands: Commands,
    cameras: Query<(&ProgressiveCamera, &Refinement, &RenderTarget)>,
    waiting: Query<(Entity, &RefinedScreenshot), Without<Screenshot>>,
    mut taken: Local<Vec<RenderTarget>>,
) {
    taken.clear();
    for (entity, RefinedScreenshot(camera)) in &waiting {
        let Ok((settings, refinement, target)) = cameras.get(*camera) else {
            warn!("no screenshot: {camera} is no ProgressiveCamera (any more)");
            commands.entity(entity).despawn();
            continue;
        };
        // Bevy takes one a frame of each target; others wait.
        let same = |other: &RenderTarget| other.normalize(None) == target.normalize(None);
        if taken.iter().any(same) || (settings.accumulate && !refinement.is_refined()) {
            continue;
        }
        taken.push(target.clone());
        commands.entity(entity).insert(Screenshot(target.clone()));
    }
}
