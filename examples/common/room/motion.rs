//! The lamp and the ball that travel on closed paths at constant speed.

use bevy::prelude::*;

/// A closed polyline, parametrized by the length travelled.
#[derive(Clone, Debug)]
pub struct ClosedPath {
    points: Vec<Vec3>,
    /// Length travelled at each point; one more than points, the last is the whole length.
    lengths: Vec<f32>,
}

impl ClosedPath {
    /// A path through at least one point and back to the first.
    pub fn new(points: &[Vec3]) -> Self {
        let mut lengths = vec![0.0];
        for (i, point) in points.iter().enumerate() {
            let next = points[(i + 1) % points.len()];
            lengths.push(lengths[i] + point.distance(next));
        }
        Self { points: points.to_vec(), lengths }
    }

    /// An ellipse around `centre` in the horizontal plane with the given half axes along x and z.
    pub fn ellipse(centre: Vec3, half_x: f32, half_z: f32) -> Self {
        let points: Vec<Vec3> = (0..128)
            .map(|i| {
                let (sin, cos) = (i as f32 / 128.0 * std::f32::consts::TAU).sin_cos();
                centre + Vec3::new(cos * half_x, 0.0, sin * half_z)
            })
            .collect();
        Self::new(&points)
    }

    /// There and back again.
    pub fn back_and_forth(points: &[Vec3]) -> Self {
        let back = points.iter().rev().skip(1).take(points.len().saturating_sub(2));
        Self::new(&points.iter().chain(back).copied().collect::<Vec<_>>())
    }

    /// Length of one round in metres.
    pub fn length(&self) -> f32 {
        self.lengths[self.points.len()]
    }

    /// The point after `distance` metres; rounds repeat.
    pub fn at(&self, distance: f32) -> Vec3 {
        let length = self.length();
        if length <= 0.0 {
            return self.points[0];
        }
        let distance = distance.rem_euclid(length);
        let i = self.lengths.partition_point(|&l| l <= distance).clamp(1, self.points.len()) - 1;
        let edge = (self.lengths[i + 1] - self.lengths[i]).max(f32::MIN_POSITIVE);
        let next = self.points[(i + 1) % self.points.len()];
        self.points[i].lerp(next, (distance - self.lengths[i]) / edge)
    }
}

/// Moves an entity along a path at constant speed.
#[derive(Component, Clone, Debug)]
pub struct Traveller {
    /// Where it goes.
    pub path: ClosedPath,
    /// Metres a second.
    pub speed: f32,
    /// Metres travelled.
    pub distance: f32,
    /// Stands still.
    pub paused: bool,
}

impl Traveller {
    /// Starts `distance` metres along the path.
    pub fn new(path: ClosedPath, speed: f32, distance: f32) -> Self {
        Self { path, speed, distance, paused: false }
    }
}

/// Advances all travellers by the frame's time.
pub fn travel(time: Res<Time>, mut travellers: Query<(&mut Traveller, &mut Transform)>) {
    for (mut traveller, mut transform) in &mut travellers {
        if !traveller.paused {
            let step = traveller.speed * time.delta_secs();
            traveller.distance = (traveller.distance + step).rem_euclid(traveller.path.length());
        }
        let place = traveller.path.at(traveller.distance);
        if transform.translation != place {
            transform.translation = place;
        }
    }
}
