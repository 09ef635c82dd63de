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
    camera::WithoutWindow,
    config::Viewer,
    headless::Headless,
    pictures::{refine, save},
    shown::Shown,
    state,
    turntable::arrive,
};

/// Largest recording that is read, in bytes.
const LARGEST: u64 = 64 << 20;

/// Reads a recording.
pub fn read(path: &Path) -> Result<Recording, String> {
    let fail = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let size = std::fs::metadata(path).map_err(|error| fail(&error))?.len();
    if size > LARGEST {
        return Err(fail(&"too large for a recording"));
    }
    let text = std::fs::read_to_string(path).map_err(|error| fail(&error))?;
    let recording: Recording = text.parse().map_err(|error| fail(&error))?;
    match recording.actions().iter().find(|name| action(name).is_none()) {
        Some(name) => Err(fail(&format!("there is no action {name}"))),
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
    let mut headless = Headless::new(size, &state::assets(), |app| {
        build(app, config);
        app.insert_resource(WithoutWindow(size)).add_systems(Last, tell);
    })?;
    headless.set_frame_time(Duration::from_millis(16));
    arrive(&mut headless)?;
    refine(&mut headless)?;
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
