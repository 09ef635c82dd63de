//! Both eyes get what the camera of the desktop has; the window shows what the left eye sees.

use bevy::{
    camera::{ClearColorConfig, Exposure, Hdr},
    core_pipeline::tonemapping::Tonemapping,
    prelude::*,
};
use farlight::xr::{XrEye, XrScreenshotSaved, XrStatus};

use super::{
    actions::Said,
    camera::{CanvasView, WindowCamera},
};

/// Eyes as they appear, and their pictures.
pub fn plugin(app: &mut App) {
    app.add_observer(dress_eye).add_systems(Update, (mirror, saved));
}

/// What else cameras need, `environment::show` and `camera::tune` give to all of them.
fn dress_eye(eye: On<Add, XrEye>, mut commands: Commands) {
    commands.entity(eye.entity).insert((
        Hdr,
        Exposure::default(),
        Tonemapping::TonyMcMapface,
        Msaa::Off,
    ));
}

/// While the headset runs the window shows an eye, behind what is written into it.
fn mirror(
    status: Res<XrStatus>,
    mut views: Query<&mut Visibility, With<CanvasView>>,
    mut cameras: Query<&mut Camera, With<WindowCamera>>,
) {
    if !status.is_changed() {
        return;
    }
    let running = *status == XrStatus::Running;
    for mut visibility in &mut views {
        visibility.set_if_neq(if running { Visibility::Hidden } else { Visibility::Inherited });
    }
    for mut camera in &mut cameras {
        camera.clear_color =
            if running { ClearColorConfig::None } else { ClearColorConfig::Default };
    }
}

/// Says what became of pictures of both eyes.
fn saved(mut pictures: MessageReader<XrScreenshotSaved>, mut said: Said) {
    for XrScreenshotSaved { path, size } in pictures.read() {
        let path = path.display();
        match size {
            Ok(size) => said.say(format!("Saved {path}, {} x {}", size.x, size.y)),
            Err(error) => said.fail(format!("{path}: {error}")),
        }
    }
}
