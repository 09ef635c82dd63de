//! Pictures without a window.

use std::{path::Path, time::Duration};

use bevy::{light::Skybox, prelude::*, render::view::screenshot::Screenshot};
use farlight::{
    btf::BtfStatus,
    ibl::{Disturb, EnvironmentState},
    prelude::*,
};

use super::{
    args::Args,
    headless::{Headless, Picture},
    orbit::Orbit,
    panel::Hud,
    scene::{self, Loading},
    shown::Shown,
};

/// Files of any size that can be shown at all arrive, and pictures are refined, in this time.
const PATIENCE: Duration = Duration::from_secs(900);
/// Frames of the strip that shows how a picture becomes better.
const STRIP: [u32; 4] = [1, 5, 20, 40];
/// Time of a frame on the app's clock.
const FRAME: Duration = Duration::from_millis(16);

struct Studio {
    headless: Headless,
    camera: Entity,
}

/// Draws what the command line asks for into `out`.
pub fn run(args: &Args, out: &Path) -> Result<(), String> {
    let size = UVec2::from(args.size.unwrap_or((640, 360)));
    let mut headless = Headless::new(size, &super::program::assets(), |app| {
        super::build(app, args.shown.clone());
        if args.turntable.is_none() {
            super::hud_systems(app);
        }
    })?;
    println!("drawn by {}", headless.adapter());
    headless.set_frame_time(FRAME);
    headless.update()?;
    let world = headless.app.world_mut();
    let camera = world.query_filtered::<Entity, With<ProgressiveCamera>>().single(world);
    let camera = camera.map_err(|e| e.to_string())?;
    let mut studio = Studio { headless, camera };
    studio.load()?;
    match args.turntable {
        Some(count) => studio.turn(count, out),
        None => studio.all(args.shown.environments.len(), out),
    }
}

impl Studio {
    fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    fn show(&mut self, change: impl FnOnce(&mut Shown)) -> Result<(), String> {
        change(&mut self.world().resource_mut::<Shown>());
        self.headless.update()
    }

    /// Waits for the models.
    fn load(&mut self) -> Result<(), String> {
        self.show_ring(false);
        self.headless.update_until("models and material", PATIENCE, |world| {
            let server = world.resource::<AssetServer>();
            let loading = world.resource::<Loading>();
            let there = loading.0.iter().all(|file| {
                let state = server.get_recursive_dependency_load_state(file);
                state.is_some_and(|state| state.is_loaded() || state.is_failed())
            });
            there && world.resource::<BtfStatus>().waiting == 0
        })?;
        let world = self.world();
        let server = world.resource::<AssetServer>();
        for file in &world.resource::<Loading>().0 {
            if let Some(bevy::asset::LoadState::Failed(error)) = server.get_load_state(file) {
                return Err(error.to_string());
            }
        }
        Ok(())
    }

    /// Waits for the environment.
    fn ready(&mut self) -> Result<(), String> {
        // The first frames ask for it.
        for _ in 0..3 {
            self.headless.update()?;
        }
        self.headless.update_until("the environment", PATIENCE, |world| {
            let mut cameras = world.query_filtered::<(), (With<ProgressiveCamera>, With<Skybox>)>();
            let seen = cameras.iter(world).next().is_some();
            match &world.resource::<EnvironmentStatus>().state {
                EnvironmentState::Failed(_) => true,
                EnvironmentState::Ready => seen,
                _ => false,
            }
        })?;
        match &self.world().resource::<EnvironmentStatus>().state {
            EnvironmentState::Failed(reason) => Err(reason.to_string()),
            _ => Ok(()),
        }
    }

    /// The picture of the first frame in which it is refined.
    fn refined(&mut self, file: &Path) -> Result<Picture, String> {
        let shot = self.headless.begin_capture(RefinedScreenshot(self.camera));
        self.finish(shot, file)
    }

    /// The picture of the next frame.
    fn next(&mut self, file: &Path) -> Result<Picture, String> {
        let screenshot = Screenshot(self.headless.target());
        let shot = self.headless.begin_capture(screenshot);
        self.finish(shot, file)
    }

    fn finish(&mut self, shot: super::headless::Capture, file: &Path) -> Result<Picture, String> {
        let picture = self.headless.finish_capture(&shot, PATIENCE)?;
        if let Some(problem) = picture.problem() {
            return Err(format!("{} is {problem}", file.display()));
        }
        picture.save(file)?;
        println!("wrote {}", file.display());
        Ok(picture)
    }

    /// Starts anew.
    fn disturb(&mut self) {
        self.world().write_message(Disturb { sphere: None, keep: 0.0 });
    }

    fn show_ring(&mut self, shown: bool) {
        let visible = if shown { Visibility::Inherited } else { Visibility::Hidden };
        let world = self.world();
        let mut roots =
            world.query_filtered::<(&mut Visibility, Has<Hud>), (With<Node>, Without<ChildOf>)>();
        for (mut visibility, is_text) in roots.iter_mut(world) {
            // The text would hide the sky of a small picture.
            visibility.set_if_neq(if is_text { Visibility::Hidden } else { visible });
        }
    }

    fn all(&mut self, environments: usize, out: &Path) -> Result<(), String> {
        for environment in 0..environments {
            self.show(|shown| {
                shown.environment = environment;
                shown.map = false;
                shown.progressive = true;
            })?;
            self.ready()?;
            let name = self.world().resource::<Shown>().chosen().name.clone();
            self.refined(&out.join(format!("{name}-refined.png")))?;
            if environment == 0 {
                self.strip(&out.join("refining.png"))?;
                self.sway(&out.join("sway.png"))?;
                self.dots(&out.join("dots.png"))?;
            }
            self.show(|shown| shown.progressive = false)?;
            let file = format!("{name}-image-based.png");
            let camera = self.camera;
            self.headless.update_until("image-based light", PATIENCE, move |world| {
                world.get::<EnvironmentMapLight>(camera).is_some()
            })?;
            self.refined(&out.join(file))?;
        }
        Ok(())
    }

    /// How a picture becomes better, frame by frame.
    fn strip(&mut self, file: &Path) -> Result<(), String> {
        self.disturb();
        let mut shots = Vec::new();
        for frame in 1..=STRIP[STRIP.len() - 1] {
            if STRIP.contains(&frame) {
                let screenshot = Screenshot(self.headless.target());
                shots.push(self.headless.begin_capture(screenshot));
            }
            self.headless.update()?;
        }
        let pictures: Result<Vec<_>, _> =
            shots.iter().map(|shot| self.headless.finish_capture(shot, PATIENCE)).collect();
        beside(&pictures?).save(file)?;
        println!("wrote {}", file.display());
        Ok(())
    }

    /// A frame in motion.
    fn sway(&mut self, file: &Path) -> Result<(), String> {
        self.show(|shown| shown.sway = true)?;
        for _ in 0..60 {
            self.headless.update()?;
        }
        self.next(file)?;
        self.show(|shown| shown.sway = false)
    }

    /// The lights on the sky, with ring and map.
    fn dots(&mut self, file: &Path) -> Result<(), String> {
        self.look(scene::SKY);
        self.show(|shown| (shown.dots, shown.map) = (true, true))?;
        self.show_ring(true);
        // What is written for the first time brings letters that were not drawn before.
        for _ in 0..12 {
            self.headless.update()?;
        }
        self.next(file)?;
        self.show_ring(false);
        self.look(scene::START);
        self.show(|shown| (shown.dots, shown.map) = (false, false))
    }

    fn look(&mut self, orbit: Orbit) {
        let camera = self.camera;
        self.world().entity_mut(camera).insert((orbit, orbit.transform()));
    }

    /// Refined pictures round the scene.
    fn turn(&mut self, count: u32, out: &Path) -> Result<(), String> {
        self.ready()?;
        for i in 0..count {
            let angle = std::f32::consts::TAU * i as f32 / count as f32;
            self.look(Orbit { yaw: scene::START.yaw + angle, ..scene::START });
            self.headless.update()?;
            self.refined(&out.join(format!("turn_{i:03}.png")))?;
        }
        Ok(())
    }
}

/// Pictures of one size from left to right.
fn beside(pictures: &[Picture]) -> Picture {
    let (width, height) = pictures.first().map_or((1, 1), |p| (p.width, p.height));
    let mut pixels = Vec::new();
    for y in 0..height as usize {
        for picture in pictures {
            pixels.extend(&picture.pixels[y * width as usize..][..width as usize]);
        }
    }
    Picture { width: width * pictures.len() as u32, height, pixels }
}
