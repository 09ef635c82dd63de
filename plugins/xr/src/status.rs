//! Whether there is a headset.

use bevy::prelude::*;

/// Whether there is a headset.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub enum XrStatus {
    /// The app is on the desktop, for this reason.
    Unavailable(String),
    /// The app has not asked yet.
    #[default]
    Unknown,
    /// There is one, but it shows nothing of the app now.
    Idle,
    /// It shows the app.
    Running,
}

/// Whether the headset's controllers are the app's: not while the runtime's own menu is open. Without a
/// headset it is false.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct XrFocus(pub bool);

/// Begins or ends showing the app in the headset; a program starts with it, if there is one.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub enum XrRequest {
    /// Show it.
    Start,
    /// Back to the desktop.
    End,
}

/// A camera of the desktop: it draws nothing while a headset shows the app.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct DesktopCamera;

/// Says once what became of the headset, where there is none.
pub(crate) fn announce(status: Res<XrStatus>) {
    if let XrStatus::Unavailable(reason) = &*status {
        info!("no headset: {reason}; the app is on the desktop");
    }
}

/// Cameras of the desktop rest while the headset runs.
pub(crate) fn rest_desktop_cameras(
    status: Res<XrStatus>,
    mut cameras: Query<(&mut Camera, Ref<DesktopCamera>)>,
) {
    for (mut camera, marker) in &mut cameras {
        if status.is_changed() || marker.is_added() {
            let is_active = *status != XrStatus::Running;
            if camera.is_active != is_active {
                camera.is_active = is_active;
            }
        }
    }
}
