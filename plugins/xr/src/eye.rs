//! The cameras of both eyes.

use bevy::{
    camera::{CameraProjection, SubCameraView},
    math::Vec3A,
    prelude::*,
    render::extract_component::ExtractComponent,
};

/// Metres behind which nothing lights or is lit; what is farther is drawn all the same.
const FAR: f32 = 1000.0;

/// The camera of an eye. It follows [`XrTracking`](crate::XrTracking); give it what cameras of the game
/// have, by an observer of `On<Add, XrEye>`.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, ExtractComponent)]
pub struct XrEye {
    /// 0 is left, 1 right.
    pub index: u32,
}

/// A field of view: angles in radians from the direction of view, to the right and up positive, each
/// between -pi/2 and pi/2. Eyes see farther outwards than inwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fov {
    /// Usually negative.
    pub left: f32,
    /// To the right.
    pub right: f32,
    /// Up.
    pub up: f32,
    /// Usually negative.
    pub down: f32,
}

impl Fov {
    /// As far to each side, in radians.
    pub const fn symmetric(half: f32) -> Self {
        Self { left: -half, right: half, up: half, down: -half }
    }

    /// Whether pictures of it can be drawn.
    pub fn is_sound(&self) -> bool {
        let right_angle = std::f32::consts::FRAC_PI_2;
        let all = [self.left, self.right, self.up, self.down];
        all.iter().all(|angle| angle.abs() < right_angle)
            && self.right > self.left
            && self.up > self.down
    }
}

/// Clip space from view space: reversed depth without a far plane, as Bevy's cameras have it.
/// `near` in metres.
pub fn eye_projection(fov: Fov, near: f32) -> Mat4 {
    let [left, right] = [fov.left.tan(), fov.right.tan()];
    let [down, up] = [fov.down.tan(), fov.up.tan()];
    between(left, right, down, up, near)
}

/// The same from the tangents of the angles.
fn between(left: f32, right: f32, down: f32, up: f32, near: f32) -> Mat4 {
    let (width, height) = (right - left, up - down);
    Mat4::from_cols(
        Vec4::new(2.0 / width, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 2.0 / height, 0.0, 0.0),
        Vec4::new((right + left) / width, (up + down) / height, 0.0, -1.0),
        Vec4::new(0.0, 0.0, near, 0.0),
    )
}

/// How an eye sees, for `Projection::custom`. Unlike `bevy_mod_xr`'s projection it has a far distance
/// of 1000 m, as Bevy's own, for what asks where light ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EyeProjection {
    /// Its field of view.
    pub fov: Fov,
    /// Metres; what is nearer is not drawn.
    pub near: f32,
}

impl Default for EyeProjection {
    /// 90 degrees, from 5 cm on.
    fn default() -> Self {
        Self { fov: Fov::symmetric(std::f32::consts::FRAC_PI_4), near: 0.05 }
    }
}

impl CameraProjection for EyeProjection {
    fn get_clip_from_view(&self) -> Mat4 {
        eye_projection(self.fov, self.near)
    }

    fn get_clip_from_view_for_sub(&self, part: &SubCameraView) -> Mat4 {
        let full = part.full_size.as_vec2().max(Vec2::ONE);
        let low = Vec2::new(self.fov.left.tan(), self.fov.down.tan());
        let high = Vec2::new(self.fov.right.tan(), self.fov.up.tan());
        let step = (high - low) / full;
        let left = low.x + part.offset.x * step.x;
        let up = high.y - part.offset.y * step.y;
        let size = part.size.as_vec2() * step;
        between(left, left + size.x, up - size.y, up, self.near)
    }

    /// A headset's fields of view are what its lenses show, whatever the picture's size.
    fn update(&mut self, _width: f32, _height: f32) {}

    fn far(&self) -> f32 {
        FAR
    }

    fn get_frustum_corners(&self, z_near: f32, z_far: f32) -> [Vec3A; 8] {
        let [left, right] = [self.fov.left.tan(), self.fov.right.tan()];
        let [down, up] = [self.fov.down.tan(), self.fov.up.tan()];
        let sides = [(right, down), (right, up), (left, up), (left, down)];
        let corner = |i: usize, z: f32| {
            let (x, y) = sides[i];
            Vec3A::new(x * z.abs(), y * z.abs(), z)
        };
        std::array::from_fn(|i| corner(i % 4, if i < 4 { z_near } else { z_far }))
    }
}

/// What makes a camera the camera of an eye; `near` in metres. It draws where the camera is told to.
pub fn eye_camera(index: u32, near: f32) -> impl Bundle {
    (
        Name::new(if index == 0 { "left eye" } else { "right eye" }),
        Camera3d::default(),
        // Before cameras of the desktop, which may show what the eyes see.
        Camera { order: index as isize - 2, ..default() },
        Projection::custom(EyeProjection { near, ..default() }),
        XrEye { index },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const EYE: Fov = Fov { left: -0.9, right: 0.7, up: 0.8, down: -0.85 };

    #[test]
    fn edges_of_the_view_are_edges_of_the_picture() {
        let clip = eye_projection(EYE, 0.1);
        for (tangents, x, y) in
            [((EYE.left, EYE.up), -1.0, 1.0), ((EYE.right, EYE.down), 1.0, -1.0)]
        {
            let place = Vec3::new(tangents.0.tan(), tangents.1.tan(), -1.0) * 3.0;
            let ndc = clip.project_point3(place);
            assert!(ndc.abs_diff_eq(Vec3::new(x, y, 0.1 / 3.0), 1e-5), "{ndc}");
        }
    }

    #[cfg(not(target_family = "wasm"))]
    #[test]
    fn it_is_the_projection_of_bevys_openxr_plugins() {
        let theirs = bevy_mod_xr::camera::calculate_projection(
            0.1,
            bevy_mod_xr::camera::Fov {
                angle_left: EYE.left,
                angle_right: EYE.right,
                angle_down: EYE.down,
                angle_up: EYE.up,
            },
        );
        assert!(eye_projection(EYE, 0.1).abs_diff_eq(theirs, 1e-6), "{theirs}");
    }

    #[test]
    fn a_symmetric_eye_is_an_ordinary_camera() {
        let camera = PerspectiveProjection { fov: 1.2, aspect_ratio: 1.0, ..default() };
        let eye = EyeProjection { fov: Fov::symmetric(0.6), near: camera.near };
        assert!(eye.get_clip_from_view().abs_diff_eq(camera.get_clip_from_view(), 1e-5));
        assert_eq!(eye.far(), camera.far());
        let [ours, theirs] = [&eye as &dyn CameraProjection, &camera]
            .map(|projection| projection.get_frustum_corners(-0.5, -20.0));
        for (ours, theirs) in ours.iter().zip(theirs) {
            assert!(ours.abs_diff_eq(theirs, 1e-4), "{ours} {theirs}");
        }
        let part = SubCameraView {
            full_size: UVec2::new(100, 100),
            offset: Vec2::new(20.0, 10.0),
            size: UVec2::new(50, 40),
        };
        let [ours, theirs] =
            [&eye as &dyn CameraProjection, &camera].map(|p| p.get_clip_from_view_for_sub(&part));
        assert!(ours.abs_diff_eq(theirs, 1e-4), "{ours} {theirs}");
    }

    #[test]
    fn senseless_fields_of_view_are_known() {
        assert!(EYE.is_sound());
        assert!(!Fov { left: 0.8, ..EYE }.is_sound());
        assert!(!Fov { up: f32::NAN, ..EYE }.is_sound());
        assert!(!Fov { down: -1.6, ..EYE }.is_sound());
    }
}
