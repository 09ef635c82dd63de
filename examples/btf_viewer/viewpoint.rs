//! Where the camera of the desktop is: it goes round a point, and walks. Both at any time: the point
//! that it goes round comes along.

use bevy::prelude::*;

/// Where the camera looks, and from where.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// The point that it goes round.
    pub target: Vec3,
    /// Metres from it.
    pub distance: f32,
    /// Turn round the vertical axis in radians; 0 looks along -z.
    pub yaw: f32,
    /// Height angle in radians; positive looks down.
    pub pitch: f32,
}

/// Factor on the distance of a step.
const STEP: f32 = 0.9;
/// Metres between camera and point.
const DISTANCES: [f32; 2] = [0.2, 30.0];
/// Nearly straight up and down.
const STEEPEST: f32 = 1.5;
/// Metres from the scene's middle that one can walk.
const FARTHEST: f32 = 100.0;

impl Viewpoint {
    /// From a place, looking at a point.
    pub fn new(place: Vec3, target: Vec3) -> Self {
        let from = place - target;
        let distance = from.length().clamp(DISTANCES[0], DISTANCES[1]);
        let pitch = (from.y / from.length().max(1e-6)).clamp(-1.0, 1.0).asin();
        let pitch = pitch.clamp(-STEEPEST, STEEPEST);
        Self { target, distance, yaw: from.x.atan2(from.z), pitch }
    }

    /// How the camera is turned.
    pub fn rotation(&self) -> Quat {
        Quat::from_euler(EulerRot::YXZ, self.yaw, -self.pitch, 0.0)
    }

    /// The camera's place.
    pub fn eye(&self) -> Vec3 {
        self.target + self.rotation() * Vec3::Z * self.distance
    }

    /// Both.
    pub fn transform(&self) -> Transform {
        Transform::from_translation(self.eye()).with_rotation(self.rotation())
    }

    /// Goes round, by degrees: what is seen follows to the right and up.
    pub fn orbit(&mut self, by: Vec2) {
        self.yaw = (self.yaw - by.x.to_radians()) % std::f32::consts::TAU;
        self.pitch = (self.pitch - by.y.to_radians()).clamp(-STEEPEST, STEEPEST);
    }

    /// Moves sideways, by thousandths of the distance: what is seen follows.
    pub fn pan(&mut self, by: Vec2) {
        let by = by * self.distance / 1000.0;
        self.target -= self.rotation() * by.extend(0.0);
        self.target = self.target.clamp_length_max(FARTHEST);
    }

    /// Comes closer by steps of a tenth of the distance.
    pub fn zoom(&mut self, steps: f32) {
        self.distance = (self.distance * STEP.powf(steps)).clamp(DISTANCES[0], DISTANCES[1]);
    }

    /// Walks to the right and forwards on the level, and rises, by metres. From then on it goes round
    /// the point straight ahead that is nearest to `middle`: the picture doesn't jump, and what is
    /// looked at stays in it.
    pub fn walk(&mut self, by: Vec2, rise: f32, middle: Vec3) {
        let level = Quat::from_rotation_y(self.yaw);
        let eye = self.eye() + level * Vec3::new(by.x, 0.0, -by.y) + Vec3::Y * rise;
        let eye = eye.clamp_length_max(FARTHEST);
        let ahead = self.rotation() * Vec3::NEG_Z;
        self.distance = ahead.dot(middle - eye).clamp(DISTANCES[0], DISTANCES[1]);
        self.target = eye + ahead * self.distance;
    }
}
