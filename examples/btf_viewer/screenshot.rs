//! Screenshots: of the canvas, as soon as it is refined, and of both eyes.

use std::path::PathBuf;

use bevy::{
    prelude::*,
    render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk},
};
use farlight::{
    prelude::*,
    xr::{XrScreenshot, XrStatus},
};

use super::{actions::Said, camera::Canvas, config::Viewer, shown::Shown, state::Config};

/// Takes the pictures that are asked for.
pub fn take(
    mut commands: Commands,
    controls: Controls,
    canvas: Option<Res<Canvas>>,
    config: Res<Config>,
    shown: Res<Shown>,
    status: Res<XrStatus>,
    refining: Query<Entity, With<ProgressiveCamera>>,
    mut shots: MessageWriter<XrScreenshot>,
    mut said: Said,
) {
    let [flat, both] =
        [controls.started::<actions::Screenshot>(), controls.started::<actions::XrScreenshot>()];
    if both && *status != XrStatus::Running {
        said.fail("No headset: no picture of both eyes was taken");
    } else if both {
        match path(&config.0, &shown, "-eyes") {
            Ok(path) => {
                shots.write(XrScreenshot(path));
            }
            Err(message) => said.fail(message),
        }
    }
    if !flat {
        return;
    }
    let Some(canvas) = canvas else { return };
    let path = match path(&config.0, &shown, "") {
        Ok(path) => path,
        Err(message) => return said.fail(message),
    };
    let told = path.display().to_string();
    // As soon as the picture is refined.
    let mut shot = match refining.iter().next() {
        Some(camera) => commands.spawn(RefinedScreenshot(camera)),
        None => commands.spawn(Screenshot::image(canvas.0.clone())),
    };
    shot.observe(save_to_disk(path)).observe(move |_: On<ScreenshotCaptured>, mut said: Said| {
        said.say(format!("Saved {told}"));
    });
}

/// A file that is not there yet in the configured folder: `object-material-lamps-1.png`, ...
pub fn path(config: &Viewer, shown: &Shown, suffix: &str) -> Result<PathBuf, String> {
    let folder = PathBuf::from(&config.screenshots);
    if let Err(error) = std::fs::create_dir_all(&folder) {
        return Err(format!("no screenshot: {}: {error}", folder.display()));
    }
    let plain = |name: &str| -> String {
        name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
    };
    let object = config.models.get(shown.object.choice);
    let object = object.map_or(String::new(), |model| plain(&model.name));
    let material = config.materials.get(shown.material.choice);
    let material = material.map_or(String::new(), |material| plain(&material.name));
    let stem = format!("{object}-{material}-{}{suffix}", shown.light.lamps.name());
    Ok((1..=9999)
        .map(|n| folder.join(format!("{stem}-{n}.png")))
        .find(|path| !path.exists())
        .unwrap_or_else(|| folder.join(format!("{stem}.png"))))
}
