//! A ball before a camera, by formula: which point of it a pixel shows.

use bevy::{
    math::{DQuat, DVec2, DVec3},
    prelude::*,
};

/// A ball of radius 1 at the origin, and a perspective camera that looks at its middle.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Where the camera is.
    pub eye: DVec3,
    /// Vertical field of view in radians; pictures are square.
    pub field_of_view: f64,
    /// Edge of the picture in pixels.
    pub size: u32,
}

/// A point of the ball that is seen; both are unit vectors.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Outwards.
    pub normal: DVec3,
    /// Towards the camera.
    pub view: DVec3,
}

impl Ball {
    /// A ball that nearly fills the picture.
    pub fn filling(size: u32) -> Self {
        Self { eye: DVec3::new(1.2, 1.0, 4.0), field_of_view: 29_f64.to_radians(), size }
    }

    /// The camera's pose where the ball's middle is at `place` instead.
    pub fn pose_at(&self, place: Vec3) -> Transform {
        Transform::from_translation(place + self.eye.as_vec3()).looking_at(place, Vec3::Y)
    }

    /// The camera's projection.
    pub fn projection(&self) -> Projection {
        Projection::Perspective(PerspectiveProjection {
            fov: self.field_of_view as f32,
            aspect_ratio: 1.0,
            ..default()
        })
    }

    /// The mesh of `sectors` by half as many facets, which lie up to `5 / sectors²` below the ball.
    pub fn mesh(&self, sectors: u32) -> Mesh {
        Sphere::new(1.0).mesh().uv(sectors, sectors / 2)
    }

    /// What a place of the picture shows, in pixels from its top left corner.
    pub fn seen_at(&self, place: DVec2) -> Option<Seen> {
        let forward = -self.eye.normalize();
        let turn: DQuat = self.pose_at(Vec3::ZERO).rotation.as_dquat();
        let (right, up) = (turn * DVec3::X, turn * DVec3::Y);
        let half = (self.field_of_view / 2.0).tan();
        let on_screen = (place / f64::from(self.size) * 2.0 - 1.0) * half;
        let ray = (forward + right * on_screen.x - up * on_screen.y).normalize();
        let along = -self.eye.dot(ray);
        let square = along * along - self.eye.length_squared() + 1.0;
        (square > 0.0).then(|| Seen {
            normal: (self.eye + ray * (along - square.sqrt())).normalize(),
            view: -ray,
        })
    }

    /// Pixels that lie on the ball, a pixel or more inside its outline: their index in the picture,
    /// rows from the top, and the centre. Of both directions every `step`th.
    pub fn pixels(&self, step: u32) -> Vec<(usize, DVec2)> {
        let mut inside = Vec::new();
        for y in (0..self.size).step_by(step as usize) {
            for x in (0..self.size).step_by(step as usize) {
                let centre = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
                let around = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y, DVec2::ZERO];
                if around.iter().all(|&offset| self.seen_at(centre + 1.5 * offset).is_some()) {
                    inside.push(((y * self.size + x) as usize, centre));
                }
            }
        }
        inside
    }
}
