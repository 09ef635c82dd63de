//! Pictures without a window: each kind of device is used once.

use std::{path::Path, time::Duration};

use bevy::prelude::*;
use farlight::controls::{ActionRecorder, ActionReplay, ReplayPace};

use crate::{
    args::Args,
    build,
    headless::Headless,
    program::assets,
    quiet_controls, recording, save,
    script::{FRAMES, KINDS, Script},
};

/// A frame.
const FRAME: Duration = Duration::from_millis(16);

/// Writes the pictures and recordings.
pub fn run(args: &Args, out: &Path) -> Result<(), String> {
    std::fs::create_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))?;
    if let Some(path) = &args.replay {
        return replay(args, path, out);
    }
    for kind in KINDS {
        let mut app = open(args)?;
        app.app.world_mut().resource_mut::<ActionRecorder>().start();
        let script = Script::new(app.app.world_mut(), kind);
        for frame in 0..FRAMES {
            draw(app.app.world_mut(), frame + 3 > FRAMES);
            script.frame(app.app.world_mut(), frame);
            app.update()?;
        }
        picture(&mut app, out, kind)?;
        let recording = app.app.world_mut().resource_mut::<ActionRecorder>().stop();
        if let Some(recording) = recording {
            save(&out.join(format!("{kind}.recording")), &recording)?;
        }
    }
    Ok(())
}

fn open(args: &Args) -> Result<Headless, String> {
    let size = UVec2::from(args.size);
    let file = args.config()?;
    let mut app = Headless::new(size, &assets(), |app| build(app, quiet_controls(file)))?;
    app.set_frame_time(FRAME);
    // What is drawn is made; nothing is asked of the devices yet.
    app.update()?;
    Ok(app)
}

/// Whether frames are drawn: only the last ones are looked at.
fn draw(world: &mut World, on: bool) {
    for mut camera in world.query::<&mut Camera>().iter_mut(world) {
        camera.is_active = on;
    }
}

fn picture(app: &mut Headless, out: &Path, name: &str) -> Result<(), String> {
    let picture = app.capture()?;
    if let Some(problem) = picture.problem() {
        return Err(format!("{name}: {problem}"));
    }
    let path = out.join(format!("{name}.png"));
    picture.save(&path)?;
    println!("{}", path.display());
    Ok(())
}

fn replay(args: &Args, path: &Path, out: &Path) -> Result<(), String> {
    let recording = recording::read(path)?;
    let mut app = open(args)?;
    let frames = recording.end().0;
    app.app.world_mut().resource_mut::<ActionReplay>().play(recording, ReplayPace::Frames);
    // Longer ones than an hour are no recordings of people.
    let frames = frames.min(216_000);
    for frame in 0..=frames {
        draw(app.app.world_mut(), frame + 3 > frames);
        app.update()?;
    }
    picture(&mut app, out, "replay")
}
