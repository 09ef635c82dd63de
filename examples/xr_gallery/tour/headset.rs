//! A headset that isn't there: its head and hands are where the tour says.

use std::time::Duration;

use bevy::{camera::RenderTarget, prelude::*, render::view::screenshot::Screenshot};
use farlight::{
    controls::{
        XrControllers,
        bindings::{Hand, Profile, Xr},
    },
    xr::{Fov, XrEye, XrHandPose, XrHead, XrRig, XrTracking, XrView, eye_camera},
};

use super::Tour;
use crate::{
    looks::{self, Adapted, FIELD},
    plan::Floor,
};

/// Metres between the eyes.
const APART: f32 = 0.063;
/// Height of the head above the floor.
pub(super) const HEAD: f32 = 1.65;
impl Tour<'_> {
    /// A head, hands, and eyes that draw into pictures of their own when they are asked to.
    pub(super) fn put_on_headset(&mut self, size: UVec2) {
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
    pub(super) fn wear(&mut self, feet: Vec3, yaw: f32, size: UVec2) {
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
    pub(super) fn point(&mut self, hand: Hand, from: Vec3, along: Vec3) {
        let turn = Transform::default().looking_to(along, Vec3::Y).rotation;
        let pose = Some(Isometry3d::new(from, turn));
        let mut tracking = self.world().resource_mut::<XrTracking>();
        *tracking.hand_mut(hand) = farlight::xr::XrHandTracking { grip: pose, aim: pose };
    }

    pub(super) fn press(&mut self, hand: Hand, input: Xr, value: Vec2) {
        self.world().resource_mut::<XrControllers>().hand_mut(hand).values.insert(input, value);
    }

    pub(super) fn hide_hands(&mut self) {
        self.world().resource_mut::<XrTracking>().hands = default();
    }

    /// What both eyes of somebody in the hall see.
    pub(super) fn stereo(&mut self) -> Result<(), String> {
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
    pub(super) fn activate(&mut self, eyes: bool) {
        let world = self.world();
        let mut cameras = world.query_filtered::<&mut Camera, With<XrEye>>();
        for mut camera in cameras.iter_mut(world) {
            camera.is_active = eyes;
        }
    }
}
