//! `--headless`: a tour of the gallery as pictures, with a head and hands that are moved by hand.

use std::{path::Path, time::Duration};

use bevy::{camera::RenderTarget, prelude::*, render::view::screenshot::Screenshot};
use farlight::{
    controls::{
        XrControllers,
        bindings::{Hand, Profile, Xr},
    },
    gi::BackendFactory,
    prelude::*,
    xr::{DesktopCamera, Fov, XrHandPose, XrHead, XrPlugin, XrRig, XrTracking, XrView, eye_camera},
};

use super::{
    args::Args,
    assets, build, exhibits,
    headless::{Headless, Picture},
    lamp::{HOME, Lamp},
    looks::{self, Adapted, FIELD},
    moving::Aiming,
    plan::Floor,
    settings::Gallery,
};

/// How long models may take to come, and light to converge.
const PATIENCE: Duration = Duration::from_secs(600);
/// Length of a frame on the app's clock.
const FRAME: Duration = Duration::from_millis(33);
/// Metres between the eyes.
const APART: f32 = 0.063;
/// Height of the head above the floor.
const HEAD: f32 = 1.65;
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

    /// A head, hands, and eyes that draw into pictures of their own when they are asked to.
    fn put_on_headset(&mut self, size: UVec2) {
        let world = self.world();
        world.spawn(XrHead);
        for hand in Hand::ALL {
            for aim in [false, true] {
                world.spawn(XrHandPose { hand, aim });
            }
            world.resource_mut::<XrControllers>().hand_mut(hand).profile = Some(Profile::Index);
        }
        self.targets = std::array::from_fn(|_| {
            let format = bevy::render::render_resource::TextureFormat::Rgba8UnormSrgb;
            let image = Image::new_target_texture(size.x, size.y, format, None);
            self.world().resource_mut::<Assets<Image>>().add(image)
        });
        for index in 0..2 {
            let target = RenderTarget::from(self.targets[index].clone());
            let order = index as isize - 2;
            let camera = Camera { is_active: false, order, ..default() };
            self.world().spawn((eye_camera(index as u32, 0.05), target)).insert(camera);
        }
        self.wear(Vec3::ZERO, 0.0, size);
    }

    /// The head is somewhere in the rig, turned to the left by so many radians.
    fn wear(&mut self, feet: Vec3, yaw: f32, size: UVec2) {
        let head = Isometry3d::new(feet + Vec3::Y * HEAD, Quat::from_rotation_y(yaw));
        // Eyes see farther outwards than inwards.
        let up = (0.5 * FIELD).to_radians();
        let aspect = size.x as f32 / size.y as f32;
        let [outwards, inwards] = [1.12, 0.88].map(|part| (up.tan() * aspect * part).atan());
        let left = Fov { left: -outwards, right: inwards, up, down: -up };
        let right = Fov { left: -inwards, right: outwards, ..left };
        let eye = |x: f32, fov: Fov| XrView {
            pose: head * Isometry3d::from_translation(Vec3::X * x),
            fov,
        };
        let eyes = [eye(-0.5 * APART, left), eye(0.5 * APART, right)];
        self.world().resource_mut::<XrTracking>().eyes = Some(eyes);
    }

    /// A hand is somewhere in the rig and points along a direction.
    fn point(&mut self, hand: Hand, from: Vec3, along: Vec3) {
        let turn = Transform::default().looking_to(along, Vec3::Y).rotation;
        let pose = Some(Isometry3d::new(from, turn));
        let mut tracking = self.world().resource_mut::<XrTracking>();
        *tracking.hand_mut(hand) = farlight::xr::XrHandTracking { grip: pose, aim: pose };
    }

    fn press(&mut self, hand: Hand, input: Xr, value: Vec2) {
        self.world().resource_mut::<XrControllers>().hand_mut(hand).values.insert(input, value);
    }

    fn hide_hands(&mut self) {
        self.world().resource_mut::<XrTracking>().hands = default();
    }

    /// What both eyes of somebody in the hall see.
    fn stereo(&mut self) -> Result<(), String> {
        let feet = Vec3::new(0.6, 0.0, 1.7);
        let world = self.world();
        world.resource_mut::<XrRig>().0 = Transform::from_translation(feet);
        world.resource_mut::<Adapted>().0 = looks::exposure(feet, world.resource::<Floor>());
        self.activate(true);
        self.frames(3)?;
        for (index, name) in ["left", "right"].into_iter().enumerate() {
            let capture =
                self.headless.begin_capture(Screenshot::image(self.targets[index].clone()));
            let picture = self.headless.finish_capture(&capture, Duration::from_secs(120))?;
            self.keep(name, &picture)?;
        }
        self.activate(false);
        Ok(())
    }

    /// Whether the eyes draw.
    fn activate(&mut self, eyes: bool) {
        let world = self.world();
        let mut cameras = world.query_filtered::<&mut Camera, With<XrEye>>();
        for mut camera in cameras.iter_mut(world) {
            camera.is_active = eyes;
        }
    }

    /// Aims into the hall with the left hand, lets go, and stands there.
    fn teleport(&mut self) -> Result<(), String> {
        let start = Vec3::new(1.6, 0.0, 2.6);
        self.world().resource_mut::<XrRig>().0 = Transform::from_translation(start);
        self.point(Hand::Left, Vec3::new(-0.2, 1.2, -0.3), Vec3::new(0.12, 0.12, -1.0));
        self.look(Vec3::new(3.3, 1.7, 3.1), Vec3::new(0.9, 0.6, -0.6))?;
        self.press(Hand::Left, Xr::Stick, Vec2::Y);
        self.frames(3)?;
        self.picture("teleport")?;
        let aimed = self.world().resource::<Aiming>().0.as_ref().and_then(|arc| arc.landing);
        self.press(Hand::Left, Xr::Stick, Vec2::ZERO);
        self.frames(3)?;
        let world = self.world();
        let mut heads = world.query_filtered::<&GlobalTransform, With<XrHead>>();
        let head = heads.iter(world).next().map(GlobalTransform::translation);
        match (aimed, head) {
            (Some(marker), Some(head)) => println!(
                "teleport: {:.2} m far, {:.4} m from the marker",
                head.xz().distance(start.xz()),
                head.xz().distance(marker.xz())
            ),
            _ => println!("teleport: aimed at nothing"),
        }
        self.hide_hands();
        Ok(())
    }

    /// The panel in the world, and a hand whose ray looks for the lantern's switch and presses it.
    fn panel(&mut self) -> Result<(), String> {
        let feet = Vec3::new(0.9, 0.0, 2.6);
        self.world().resource_mut::<XrRig>().0 = Transform::from_translation(feet);
        self.world().resource_mut::<PanelState>().menu = true;
        let hand = Vec3::new(0.24, HEAD - 0.42, -0.28);
        let ahead = Vec3::new(0.0, HEAD - 0.15, -1.2);
        self.point(Hand::Right, hand, ahead - hand);
        self.look(
            feet + Vec3::new(-0.28, HEAD + 0.08, 0.12),
            feet + Vec3::new(0.1, HEAD - 0.2, -1.2),
        )?;
        self.frames(30)?;
        self.activate_desktop(false);
        let found = self.press_switch(hand)?;
        self.activate_desktop(true);
        match found {
            Some(target) => println!("panel: pressed the lantern's switch at {target:.2}"),
            None => println!("panel: nothing was pressed"),
        }
        self.frames(6)?;
        self.picture("panel")?;
        self.world().resource_mut::<PanelState>().menu = false;
        self.world().resource_mut::<Gallery>().lamp = true;
        self.hide_hands();
        self.frames(3)
    }

    /// Moves the right hand's ray over the panel, line by line from the right, and presses until the
    /// lantern goes out. Says where that was.
    fn press_switch(&mut self, hand: Vec3) -> Result<Option<Vec3>, String> {
        for row in 0..24 {
            for column in 0..22 {
                let target =
                    Vec3::new(0.42 - 0.04 * column as f32, HEAD + 0.40 - 0.03 * row as f32, -1.25);
                self.point(Hand::Right, hand, target - hand);
                self.frames(1)?;
                if !self.meets_panel() {
                    continue;
                }
                for pressed in [1.0, 0.0] {
                    self.press(Hand::Right, Xr::Trigger, Vec2::new(pressed, 0.0));
                    self.frames(2)?;
                }
                if !self.world().resource::<Gallery>().lamp {
                    return Ok(Some(target));
                }
                if !self.world().resource::<PanelState>().menu {
                    // That was the cross.
                    self.world().resource_mut::<PanelState>().menu = true;
                    self.frames(4)?;
                }
            }
        }
        Ok(None)
    }

    fn meets_panel(&mut self) -> bool {
        let world = self.world();
        let mut rays = world.query::<&PanelRay>();
        rays.iter(world).any(|ray| ray.hand == Some(Hand::Right) && ray.hit.is_some())
    }

    /// Whether the camera of the desktop draws.
    fn activate_desktop(&mut self, draws: bool) {
        let world = self.world();
        let mut cameras = world.query_filtered::<&mut Camera, With<DesktopCamera>>();
        for mut camera in cameras.iter_mut(world) {
            camera.is_active = draws;
        }
    }

    /// The right hand takes the lantern into another room, and its light follows.
    fn carry_lamp(&mut self) -> Result<(), String> {
        let from_feet = Vec3::new(0.0, HOME.y, -0.5);
        let there = Vec3::new(-6.0, HOME.y, 0.3);
        self.point(Hand::Right, from_feet, Vec3::NEG_Z);
        self.world().resource_mut::<XrRig>().0 = Transform::from_translation(HOME - from_feet);
        self.frames(2)?;
        self.press(Hand::Right, Xr::Squeeze, Vec2::X);
        self.frames(3)?;
        self.world().resource_mut::<XrRig>().0 = Transform::from_translation(there - from_feet);
        self.frames(3)?;
        self.press(Hand::Right, Xr::Squeeze, Vec2::ZERO);
        self.frames(2)?;
        self.hide_hands();
        let world = self.world();
        let mut lamps = world.query_filtered::<&GlobalTransform, With<Lamp>>();
        if let Some(lamp) = lamps.iter(world).next().map(GlobalTransform::translation) {
            println!(
                "lantern: carried {:.2} m, {:.4} m from the hand",
                lamp.distance(HOME),
                lamp.distance(there)
            );
        }
        self.converge()?;
        let (_, eyes, at) = VIEWS[WINDOW_ROOM];
        self.look(eyes, at)?;
        self.picture("lantern_by_the_window")?;
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
