//! Pictures of the program as people see it, without a window and without a headset: the first
//! screen, help, menu, and what both eyes of somebody see who points at the menu.

use std::{path::Path, time::Duration};

use bevy::{
    camera::RenderTarget,
    math::Isometry3d,
    prelude::*,
    render::{render_resource::TextureFormat, view::screenshot::Screenshot},
};
use farlight::{
    controls::{
        XrControllers,
        bindings::{Hand, Profile},
    },
    panel::PanelRay,
    prelude::*,
    xr::{Fov, XrHandPose, XrHead, XrStatus, XrTracking, XrView, eye_camera},
};

use super::{
    camera::WithoutWindow,
    config::Viewer,
    headless::{Headless, Picture},
    program,
    stage::Stage,
    state,
    turntable::{PATIENCE, arrive},
};

/// Metres between the eyes.
const APART: f32 = 0.063;
/// Tangent of half an eye's field of view, up and down.
const TALL: f32 = 0.8;
/// How much farther an eye sees outwards than inwards.
const OUTWARDS: f32 = 1.15;

/// Writes all of them into `out`.
pub fn run(
    config: Viewer,
    out: &Path,
    size: UVec2,
    build: impl FnOnce(&mut App, Viewer),
) -> Result<(), String> {
    let mut headless = start(config, size, build)?;
    println!("drawn by {}", headless.adapter());
    save(&headless.capture()?, out, "first")?;
    let open = |headless: &mut Headless, menu: bool, help: bool| -> Result<(), String> {
        let mut state = headless.app.world_mut().resource_mut::<PanelState>();
        (state.menu, state.help) = (menu, help);
        for _ in 0..6 {
            headless.update()?;
        }
        Ok(())
    };
    open(&mut headless, false, true)?;
    save(&headless.capture()?, out, "help")?;
    open(&mut headless, true, false)?;
    save(&headless.capture()?, out, "menu")?;
    let eyes = wear(&mut headless, size);
    open(&mut headless, true, false)?;
    refine(&mut headless)?;
    let hits: Vec<f32> = {
        let world = headless.app.world_mut();
        world.query::<&PanelRay>().iter(world).filter_map(|ray| ray.hit).collect()
    };
    println!("{} of 2 hands point at the panel", hits.len());
    for (image, name) in eyes.iter().zip(["left", "right"]) {
        let shot = headless.begin_capture(Screenshot::image(image.clone()));
        save(&headless.finish_capture(&shot, PATIENCE)?, out, name)?;
    }
    println!("wrote first, help, menu, left and right into {}", out.display());
    Ok(())
}

/// Starts the program without a window, and waits until its picture is refined.
pub fn start(
    config: Viewer,
    size: UVec2,
    build: impl FnOnce(&mut App, Viewer),
) -> Result<Headless, String> {
    let mut headless = Headless::new(size, &program::assets(), |app| {
        build(app, config);
        app.insert_resource(WithoutWindow(size));
    })?;
    headless.set_frame_time(Duration::from_millis(16));
    arrive(&mut headless)?;
    refine(&mut headless)?;
    Ok(headless)
}

/// Writes a picture, if it shows anything.
pub fn save(picture: &Picture, out: &Path, name: &str) -> Result<(), String> {
    match picture.problem() {
        Some(problem) => Err(format!("the picture {name} is {problem}")),
        None => picture.save(out.join(format!("{name}.png"))),
    }
}

/// Runs frames until all pictures are refined that refine themselves.
pub fn refine(headless: &mut Headless) -> Result<(), String> {
    headless.update_until("the picture's light", PATIENCE, |world| {
        let mut cameras = world.query::<(&Camera, &Refinement)>();
        cameras.iter(world).all(|(camera, refinement)| !camera.is_active || refinement.is_refined())
    })
}

/// Puts a simulated headset on: eyes that look at the object, a right hand that points at the panel.
fn wear(headless: &mut Headless, size: UVec2) -> [Handle<Image>; 2] {
    let world = headless.app.world_mut();
    world.insert_resource(XrStatus::Running);
    let config = world.resource::<state::Config>().0.clone();
    let stage = Stage::new(&config, true);
    let head = Transform::from_xyz(0.0, 1.55, 0.15).looking_at(stage.middle, Vec3::Y);
    let wide = TALL * size.x as f32 / size.y as f32;
    let eye = |side: f32| {
        let [left, right] = [-wide, wide]
            .map(|edge: f32| if edge * side > 0.0 { edge * OUTWARDS } else { edge / OUTWARDS });
        let fov =
            Fov { left: left.atan(), right: right.atan(), up: TALL.atan(), down: -TALL.atan() };
        let place = head.transform_point(Vec3::X * side * APART / 2.0);
        XrView { pose: Isometry3d::new(place, head.rotation), fov }
    };
    let mut tracking = world.resource_mut::<XrTracking>();
    tracking.eyes = Some([eye(-1.0), eye(1.0)]);
    for (hand, side) in [(Hand::Left, -1.0), (Hand::Right, 1.0)] {
        let place = Transform::from_xyz(0.16 * side, 1.25, -0.25)
            .looking_at(Vec3::new(0.05 * side, 1.4, -1.0), Vec3::Y);
        let place = Isometry3d::new(place.translation, place.rotation);
        let tracked = tracking.hand_mut(hand);
        (tracked.grip, tracked.aim) = (Some(place), Some(place));
    }
    let mut controllers = world.resource_mut::<XrControllers>();
    for hand in Hand::ALL {
        controllers.hand_mut(hand).profile = Some(Profile::Touch);
    }
    world.spawn(XrHead);
    for hand in Hand::ALL {
        for aim in [false, true] {
            world.spawn(XrHandPose { hand, aim });
        }
    }
    let images = [0, 1].map(|_| {
        let image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
        world.resource_mut::<Assets<Image>>().add(image)
    });
    for (index, image) in images.iter().enumerate() {
        world.spawn((eye_camera(index as u32, 0.05), RenderTarget::from(image.clone())));
    }
    images
}
