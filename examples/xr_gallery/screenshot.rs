//! Screenshots: of the window, and of both eyes.

use std::path::{Path, PathBuf};

use bevy::{
    prelude::*,
    render::view::screenshot::{Screenshot, save_to_disk},
};
use farlight::{
    prelude::*,
    xr::{XrScreenshot, XrScreenshotSaved},
};

/// Takes the pictures that are asked for, into the folder `screenshots`.
pub fn plugin(app: &mut App) {
    app.add_systems(Update, (take, saved));
}

fn take(
    controls: Controls,
    headset: Res<XrStatus>,
    mut shots: MessageWriter<XrScreenshot>,
    mut said: MessageWriter<Notification>,
    mut commands: Commands,
) {
    if controls.started::<actions::XrScreenshot>() {
        if *headset == XrStatus::Running {
            shots.write(XrScreenshot(path("eyes")));
        } else {
            said.write(Notification::problem("No headset: no picture of both eyes was taken"));
        }
    }
    if controls.started::<actions::Screenshot>() {
        let path = path("gallery");
        if let Some(folder) = path.parent()
            && let Err(error) = std::fs::create_dir_all(folder)
        {
            said.write(Notification::problem(format!("{}: {error}", folder.display())));
            return;
        }
        said.write(Notification::new(format!("Saved {}", path.display())));
        commands.spawn(Screenshot::primary_window()).observe(save_to_disk(path));
    }
}

fn saved(mut pictures: MessageReader<XrScreenshotSaved>, mut said: MessageWriter<Notification>) {
    for XrScreenshotSaved { path, size } in pictures.read() {
        said.write(match size {
            Ok(_) => Notification::new(format!("Saved {}", path.display())),
            Err(reason) => Notification::problem(format!("{}: {reason}", path.display())),
        });
    }
}

/// A file that is not there yet.
fn path(stem: &str) -> PathBuf {
    let folder = Path::new("screenshots");
    (1..=9999)
        .map(|n| folder.join(format!("{stem}-{n}.png")))
        .find(|path| !path.exists())
        .unwrap_or_else(|| folder.join(format!("{stem}.png")))
}
