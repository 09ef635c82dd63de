//! What the backend can't see by itself: windows and cameras.

use std::time::Duration;

use bevy::{camera::Projection, platform::time::Instant, prelude::*, window::PrimaryWindow};
use farlight_core::RonPlugin;
use farlight_gi::{GiBackend, LightingBackend};
use farlight_wire::View;

use crate::{RemoteBackend, RemoteSettings};

/// A window that is being dragged changes its size every frame; what has rested so long is final.
const REST: Duration = Duration::from_millis(300);

/// Registers [`RemoteSettings`] as an asset. When the primary window has a new size, it tells the server
/// where the game looks from and asks for all light again. Without a [`RemoteBackend`] it does nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct RemotePlugin;

impl Plugin for RemotePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(RonPlugin::<RemoteSettings>::default())
            .add_systems(PostUpdate, follow_window);
    }
}

/// Sizes of the window in physical pixels.
#[derive(Default)]
struct Sizes {
    /// Which the server knows of.
    told: Option<UVec2>,
    /// Of the last frame, and since when.
    seen: Option<(UVec2, Instant)>,
    frame: u64,
}

fn follow_window(
    mut sizes: Local<Sizes>,
    windows: Query<&Window, With<PrimaryWindow>>,
    cameras: Query<(&Camera, &GlobalTransform, &Projection), With<Camera3d>>,
    backend: Option<ResMut<GiBackend>>,
) {
    sizes.frame += 1;
    let (Ok(window), Some(mut backend)) = (windows.single(), backend) else { return };
    let size = window.physical_size();
    if sizes.told == Some(size) {
        sizes.seen = None;
        return;
    }
    match sizes.seen {
        Some((seen, since)) if seen == size => {
            if since.elapsed() < REST {
                return;
            }
        }
        _ => {
            sizes.seen = Some((size, Instant::now()));
            return;
        }
    }
    let before = sizes.told.replace(size);
    let Some(backend) = backend.downcast_mut::<RemoteBackend>() else { return };
    if before.is_some() {
        backend.resync();
    }
    let active = cameras.iter().filter(|(camera, ..)| camera.is_active);
    if let Some((camera, transform, projection)) = active.min_by_key(|(camera, ..)| camera.order) {
        let (_, rotation, position) = transform.to_scale_rotation_translation();
        backend.set_view(View {
            id: 0,
            frame: sizes.frame,
            position,
            rotation,
            projection: projection.get_clip_from_view(),
            size: camera.physical_target_size().unwrap_or(size),
            predicted: Vec::new(),
        });
    }
}
