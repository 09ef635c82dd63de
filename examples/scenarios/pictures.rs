//! Pictures of the day without a window.

use std::{path::Path, time::Duration};

use bevy::prelude::*;
use farlight::prelude::*;

use super::{
    args::Args,
    build,
    day::{Day, HOURS},
    headless::{Headless, Picture},
    program::assets,
};

/// Writes them.
pub fn run(args: &Args, out: &Path) -> Result<(), String> {
    let size = UVec2::from(args.size);
    let mut headless = Headless::new(size, &assets(), |app| {
        build(app);
        app.insert_resource(Day { paused: true, ..default() });
    })?;
    headless.set_frame_time(Duration::from_millis(16));
    headless.update_until("the room", Duration::from_secs(60), |world| {
        let status = world.resource::<BakedStatus>();
        status.roots.iter().any(|root| root.state != BakedState::Loading)
    })?;
    let status = headless.app.world().resource::<BakedStatus>();
    if let Some(BakedState::Failed { reason }) = status.roots.first().map(|root| &root.state) {
        return Err(reason.to_string());
    }
    let mut pictures = Vec::new();
    for index in 0..args.pictures {
        let along = index as f32 / (args.pictures - 1).max(1) as f32;
        let hour = HOURS[0] + (HOURS[1] - HOURS[0]) * along;
        headless.app.world_mut().resource_mut::<Day>().hour = hour;
        for _ in 0..3 {
            headless.update()?;
        }
        let picture = headless.capture_still()?;
        let file = out.join(format!("day_{index:02}.png"));
        picture.save(&file)?;
        println!("wrote {} at {hour:.1} o'clock", file.display());
        pictures.push(picture);
    }
    let file = out.join("strip.png");
    strip(&pictures).save(&file)?;
    println!("wrote {}", file.display());
    Ok(())
}

/// Pictures of one size beside each other.
fn strip(pictures: &[Picture]) -> Picture {
    let height = pictures.first().map_or(0, |picture| picture.height);
    let width = pictures.iter().map(|picture| picture.width).sum();
    let rows = (0..height as usize).flat_map(|y| {
        pictures.iter().flat_map(move |picture| {
            let width = picture.width as usize;
            picture.pixels[y * width..(y + 1) * width].iter().copied()
        })
    });
    Picture { width, height, pixels: rows.collect() }
}
