//! Actions from a recording instead of devices; without a window, pictures before and after.

use std::{path::Path, time::Duration};

use bevy::prelude::*;
use farlight::{
    controls::{
        ActionReplay, ReplayPace,
        bindings::{Recording, action},
    },
    prelude::*,
};

use super::{
    config::Viewer,
    pictures::{refine, save, start},
    recording,
    shown::Shown,
    turntable::arrive,
};

/// Reads a recording of the suite's actions.
pub fn read(path: &Path) -> Result<Recording, String> {
    let recording = recording::read(path)?;
    match recording.actions().iter().find(|name| action(name).is_none()) {
        Some(name) => Err(format!("{}: there is no action {name}", path.display())),
        None => Ok(recording),
    }
}

/// Writes what happens to the console.
pub fn tell(mut notifications: MessageReader<Notification>) {
    for notification in notifications.read() {
        println!("{}", notification.text);
    }
}

/// Plays a recording without a window: `before.png` and `after.png` in `out`, and what was said and
/// what is shown in the end on the console.
pub fn run(
    config: Viewer,
    recording: Recording,
    out: &Path,
    size: UVec2,
    build: impl FnOnce(&mut App, Viewer),
) -> Result<(), String> {
    let mut headless = start(config, size, |app, config| {
        build(app, config);
        app.add_systems(Last, tell);
    })?;
    save(&headless.capture()?, out, "before")?;
    let world = headless.app.world_mut();
    world.resource_mut::<ActionReplay>().play(recording, ReplayPace::Frames);
    headless.update_until("the recording's end", Duration::from_secs(3600), |world| {
        !world.resource::<ActionReplay>().is_playing()
    })?;
    arrive(&mut headless)?;
    refine(&mut headless)?;
    save(&headless.capture()?, out, "after")?;
    println!("{:?}", headless.app.world().resource::<Shown>());
    Ok(())
}
