//! The turntable without a window.

use std::{path::Path, time::Duration};

use bevy::prelude::*;
use farlight::{btf::BtfStatus, prelude::*};

use super::{
    config::Viewer,
    environment,
    headless::{Headless, Picture},
    material::Materials,
    object::{Arriving, Unfitted},
    program,
    shown::{Shown, degrees},
    state::Problems,
};

/// Files of any size that can be shown at all arrive in this time.
pub const PATIENCE: Duration = Duration::from_secs(600);
/// Pictures in a row of the contact sheet.
const COLUMNS: usize = 4;

/// Draws `frames` pictures of a whole turn into `out`.
pub fn run(
    config: Viewer,
    out: &Path,
    frames: u32,
    size: UVec2,
    build: impl FnOnce(&mut App, Viewer),
) -> Result<(), String> {
    let mut headless = Headless::new(size, &program::assets(), |app| {
        build(app, config);
    })?;
    println!("drawn by {}", headless.adapter());
    arrive(&mut headless)?;
    // A camera that refines its picture says itself when it is done.
    let world = headless.app.world_mut();
    let refining = world.query_filtered::<Entity, With<ProgressiveCamera>>().single(world).ok();
    if refining.is_none() {
        headless.capture_still()?;
    }
    let mut pictures = Vec::new();
    for frame in 0..frames {
        let turn = 360.0 * frame as f32 / frames as f32;
        headless.app.world_mut().resource_mut::<Shown>().object.turn = degrees(turn);
        headless.update()?;
        let picture = match refining {
            Some(camera) => {
                let shot = headless.begin_capture(RefinedScreenshot(camera));
                headless.finish_capture(&shot, PATIENCE)?
            }
            None => headless.capture()?,
        };
        if let Some(problem) = picture.problem() {
            return Err(format!("the picture at {turn} degrees is {problem}"));
        }
        let file = out.join(format!("frame_{frame:03}.png"));
        picture.save(file)?;
        pictures.push(picture);
    }
    let sheet = out.join("contact.png");
    contact_sheet(&pictures).save(&sheet)?;
    println!("wrote {} pictures and {}", pictures.len(), sheet.display());
    Ok(())
}

/// Runs frames until everything that is shown has been read.
pub fn arrive(headless: &mut Headless) -> Result<(), String> {
    // The first frames ask for the files.
    for _ in 0..3 {
        headless.update()?;
    }
    headless.update_until("object, material and environment", PATIENCE, |world| {
        let busy = world.resource::<Materials>().busy() || environment::is_busy(world);
        let mut arriving = world.query_filtered::<(), Or<(With<Arriving>, With<Unfitted>)>>();
        !busy && arriving.iter(world).next().is_none()
    })?;
    for _ in 0..2 {
        headless.update()?;
    }
    headless.update_until("the material on the GPU", PATIENCE, |world| {
        world.resource::<BtfStatus>().waiting == 0
    })?;
    let problems: Vec<String> =
        headless.app.world().resource::<Problems>().all().map(Into::into).collect();
    if problems.is_empty() { Ok(()) } else { Err(problems.join("\n")) }
}

/// All pictures in rows, made smaller by whole factors until the sheet is at most 2048 wide.
fn contact_sheet(pictures: &[Picture]) -> Picture {
    let columns = pictures.len().clamp(1, COLUMNS);
    let rows = pictures.len().div_ceil(columns);
    let (width, height) =
        pictures.first().map_or((1, 1), |p| (p.width as usize, p.height as usize));
    let factor = (columns * width).div_ceil(2048).max(1);
    let (w, h) = ((width / factor).max(1), (height / factor).max(1));
    let mut pixels = vec![[0; 3]; columns * w * rows * h];
    for (i, picture) in pictures.iter().enumerate() {
        let (left, top) = (i % columns * w, i / columns * h);
        for y in 0..h {
            for x in 0..w {
                let mut sum = [0_u32; 3];
                for k in 0..factor * factor {
                    let (dx, dy) = (k % factor, k / factor);
                    let at = (y * factor + dy) * width + x * factor + dx;
                    let pixel = picture.pixels[at.min(picture.pixels.len() - 1)];
                    sum = [0, 1, 2].map(|c| sum[c] + u32::from(pixel[c]));
                }
                let count = (factor * factor) as u32;
                pixels[(top + y) * columns * w + left + x] = sum.map(|v| (v / count) as u8);
            }
        }
    }
    Picture { width: (columns * w) as u32, height: (rows * h) as u32, pixels }
}
