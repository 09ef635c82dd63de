//! `--headless`: a tour of the gallery as pictures, with a head and hands that are moved by hand.

mod acts;
mod headset;

use std::{path::Path, time::Duration};

use bevy::prelude::*;
use farlight::{
    gi::BackendFactory,
    prelude::*,
    xr::{DesktopCamera, XrPlugin},
};

use super::{
    args::Args,
    build, exhibits,
    headless::{Headless, Picture},
    looks::{self, Adapted},
    plan::Floor,
    program::assets,
    settings::Gallery,
};

/// How long models may take to come, and light to converge.
const PATIENCE: Duration = Duration::from_secs(600);
/// Length of a frame on the app's clock.
const FRAME: Duration = Duration::from_millis(33);
/// Views of the tour: name, eyes, what they look at.
const VIEWS: &[(&str, Vec3, Vec3)] = &[
    ("hall", Vec3::new(0.3, 1.62, 3.0), Vec3::new(0.0, 1.15, -1.5)),
    ("red_room", Vec3::new(5.2, 1.6, 1.5), Vec3::new(7.2, 1.05, -2.0)),
    ("through_the_door", Vec3::new(2.6, 1.6, 1.0), Vec3::new(7.2, 1.1, -1.6)),
    ("window_room", Vec3::new(-5.0, 1.6, 1.4), Vec3::new(-7.6, 1.0, -1.6)),
    ("skylight", Vec3::new(-2.9, 1.3, 2.6), Vec3::new(0.6, 2.5, -1.2)),
];

/// Index in [`VIEWS`] of the room that the lantern is carried into.
const WINDOW_ROOM: usize = 3;

/// The tour under way.
struct Tour<'a> {
    headless: Headless,
    out: &'a Path,
    targets: [Handle<Image>; 2],
    pictures: u32,
}

/// Makes the tour.
pub fn run(args: &Args, light: BackendFactory, out: &Path) -> Result<(), String> {
    let size = UVec2::from(args.size.unwrap_or((960, 540)));
    let headless = Headless::new(size, &assets(), |app| {
        app.add_plugins(XrPlugin::default());
        build(app, args, light);
    })?;
    let mut tour = Tour { headless, out, targets: default(), pictures: 0 };
    tour.headless.set_frame_time(FRAME);
    tour.world().resource_mut::<Gallery>().turning = false;
    tour.put_on_headset(size);
    tour.headless.update_until("the models", PATIENCE, exhibits::complete)?;
    tour.converge()?;
    println!("adapter: {}", tour.headless.adapter());
    tour.say_light();

    for (name, eyes, at) in VIEWS {
        tour.look(*eyes, *at)?;
        tour.picture(name)?;
    }
    tour.compare_with_direct_light()?;
    tour.stereo()?;
    tour.teleport()?;
    tour.panel()?;
    tour.carry_lamp()?;
    for frame in 0..args.frames {
        tour.turn(frame, args.frames)?;
    }
    println!("pictures: {} in {}", tour.pictures, out.display());
    Ok(())
}

impl Tour<'_> {
    fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    fn frames(&mut self, count: u32) -> Result<(), String> {
        (0..count).try_for_each(|_| self.headless.update())
    }

    /// Waits until light is as good as it gets.
    fn converge(&mut self) -> Result<(), String> {
        // A change is submitted in the frame after.
        self.frames(3)?;
        let step = Duration::from_millis(5);
        self.headless.update_until("the light", PATIENCE, |world| {
            std::thread::sleep(step);
            let status = world.resource::<GiStatus>();
            let still = status.converting == 0 && status.shown == status.submitted;
            matches!(status.state, GiState::Failed { .. })
                || status.receivers > 0 && still && status.state == GiState::Converged
        })?;
        match &self.world().resource::<GiStatus>().state {
            GiState::Failed { reason } => Err(format!("no indirect light: {reason}")),
            _ => self.frames(4),
        }
    }

    fn say_light(&mut self) {
        let status = self.world().resource::<GiStatus>();
        println!(
            "light: {} meshes lit, {} left out, estimated error {:.1} %, {} updates",
            status.receivers,
            status.left_out.len(),
            status.quality.relative_error * 100.0,
            status.updates
        );
        for left_out in &status.left_out {
            println!("left out: {} {}", left_out.entity, left_out.reason);
        }
    }

    /// The camera of the desktop looks somewhere, used to the light there.
    fn look(&mut self, eyes: Vec3, at: Vec3) -> Result<(), String> {
        let world = self.world();
        let exposure = looks::exposure(eyes, world.resource::<Floor>());
        world.resource_mut::<Adapted>().0 = exposure;
        let mut cameras = world.query_filtered::<&mut Transform, With<DesktopCamera>>();
        for mut transform in cameras.iter_mut(world) {
            *transform = Transform::from_translation(eyes).looking_at(at, Vec3::Y);
        }
        self.frames(3)
    }

    /// Takes a picture of what the camera of the desktop sees.
    fn picture(&mut self, name: &str) -> Result<Picture, String> {
        let picture = self.headless.capture()?;
        self.keep(name, &picture)?;
        Ok(picture)
    }

    fn keep(&mut self, name: &str, picture: &Picture) -> Result<(), String> {
        let path = self.out.join(format!("{name}.png"));
        picture.save(&path)?;
        self.pictures += 1;
        match picture.problem() {
            Some(problem) => Err(format!("{}: {problem}", path.display())),
            None => Ok(()),
        }
    }

    /// A corner that no lamp and no sun shines into, with and without indirect light.
    fn compare_with_direct_light(&mut self) -> Result<(), String> {
        self.look(Vec3::new(7.6, 1.6, -0.6), Vec3::new(9.2, 0.6, 1.9))?;
        let full = self.picture("corner")?;
        self.world().resource_mut::<GiControl>().enabled = false;
        self.frames(4)?;
        let direct = self.picture("corner_direct")?;
        self.world().resource_mut::<GiControl>().enabled = true;
        self.frames(4)?;
        println!(
            "corner: {:.1} of 255 with indirect light, {:.1} without",
            full.mean(),
            direct.mean()
        );
        Ok(())
    }

    /// A picture of the sculpture's turn.
    fn turn(&mut self, frame: u32, count: u32) -> Result<(), String> {
        let world = self.world();
        let mut turning = world.query_filtered::<&mut Transform, With<exhibits::Turning>>();
        for mut transform in turning.iter_mut(world) {
            transform.rotate_y(std::f32::consts::TAU / count as f32);
        }
        self.look(Vec3::new(0.9, 1.35, 1.3), Vec3::new(0.0, 0.85, -0.9))?;
        self.picture(&format!("turn_{frame:03}"))?;
        Ok(())
    }
}
